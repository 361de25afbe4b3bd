{% set kinds = {"real": prefix ~ "_real", "clock": prefix ~ "_clock", "index": "int32_t"} %}
/*
 * Calibration of a force/torque sensor. Computes the load from the gauges, one sample at a time.
 *
{% for fact in facts %}
 * {{ fact|comment }}
{% endfor %}
 *
 * Use: keep one state per sensor, in static memory because it may be large. For C++, there is the class {{ prefix }}_estimator
 * at the end of this file.
 *
 *     static {{ prefix }}_state state;
 *     {{ prefix }}_init(&state);
 *     for each sample:
 *         status = {{ prefix }}_update(&{{ PREFIX }}_CALIBRATION, &state, time, gauges{{ ", auxiliary" if auxiliary }}, load, NULL);
 *         if ({{ PREFIX }}_IS_REJECTED(status)) there is no load
 *
{% if auxiliary %}
 * Auxiliary channels, in this order and unit. A value that leaves its range by more than a tenth of the range sets the
 * flag BEYOND:
{% for channel in auxiliary %}
 *     {{ channel|comment }}
{% endfor %}
 *
{% endif %}
 * Gauges have the order above and the unit of the training recordings; loads have the order and units above. The history is
 * empty at the first sample after init. The time is passed in one of three forms:
 *     {{ prefix }}_update        seconds on any clock, a double;
 *     {{ prefix }}_update_ticks  a 32-bit counter that may wrap, with LOOPSCOPE_TICKS_PER_SECOND (1000000) ticks in a second;
 *     {{ prefix }}_update_step   seconds since the last call, even if that sample was rejected.
 * Use the same form for all samples. With float numbers, update_ticks and update_step need no double arithmetic. A pause that is
 * longer than the range of the internal clock is a gap. Whole turns of a counter cannot be detected: after a pause that may be longer than
 * 2^32 ticks, call {{ prefix }}_init, or {{ prefix }}_tare.
 *
{% for line in statuses %}
 * {{ line }}
{% endfor %}
 * Each name has the prefix {{ PREFIX }}_.
 *
 * To tare an unloaded sensor, pass the mean of its gauges over several samples to {{ prefix }}_tare.
 *
 * To test this code on your machine, export the same calibration as {{ prefix }}.zip. It contains a test vector (expected.csv)
 * and a program (main.c) that runs it and prints PASS or FAIL.
 *
 * LOOPSCOPE_REAL is the type of the numbers: double, or float if you define it so. It must be the same wherever this file is
 * included. Do not compile it with -ffast-math.
 *
{% if ring %}
 * The history stores at most one sample in {{ history_step_secs|plain }} s, at any sample rate.
{% endif %}
 * Memory of the state: about {{ bytes_double }} bytes in double, {{ bytes_float }} in float.
 * Cost of an update: {{ products }} multiplications{{ search_cost }}, for every sample; no heap, no recursion.
{% if look_backs %}
 * If a load differs from a past load by almost exactly F_th, float and double code may find different past samples.
{% endif %}
 */
#ifndef {{ PREFIX }}_H
#define {{ PREFIX }}_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LOOPSCOPE_REAL
#define LOOPSCOPE_REAL double
#endif
#ifndef LOOPSCOPE_TICKS_PER_SECOND
#define LOOPSCOPE_TICKS_PER_SECOND 1000000
#endif

/* LOOPSCOPE_N converts a number, LOOPSCOPE_SECS a time, to the types in use. */
#ifndef LOOPSCOPE_N
#define LOOPSCOPE_IS_float 1
#define LOOPSCOPE_IS_double 0
#define LOOPSCOPE_JOIN_(a, b) a##b
#define LOOPSCOPE_JOIN(a, b) LOOPSCOPE_JOIN_(a, b)
#if LOOPSCOPE_JOIN(LOOPSCOPE_IS_, LOOPSCOPE_REAL)
#define LOOPSCOPE_FLOAT 1
#define LOOPSCOPE_N(x) x##f
#define LOOPSCOPE_SECS(x) ((uint32_t)((x) * (1.0 * LOOPSCOPE_TICKS_PER_SECOND) + 0.5))
#else
#define LOOPSCOPE_FLOAT 0
#define LOOPSCOPE_N(x) x
#define LOOPSCOPE_SECS(x) (x)
#endif
#endif

#define {{ PREFIX }}_GAUGES {{ n_gauges }}
#define {{ PREFIX }}_AXES {{ n_axes }}
{% if auxiliary %}
#define {{ PREFIX }}_AUXILIARY {{ n_auxiliary }}
{% endif %}
/* Number of gauges and columns of the feature blocks. */
#define {{ PREFIX }}_COLUMNS {{ n_columns }}
{% if ring %}
/* Number of stored samples: whole boxes of 256. */
#define {{ PREFIX }}_RING {{ ring_samples }}
#if LOOPSCOPE_FLOAT && {{ window_ms }} > 2147483647 / LOOPSCOPE_TICKS_PER_SECOND * 1000
#error "The history is longer than the ticks can count: define a smaller LOOPSCOPE_TICKS_PER_SECOND"
#endif
{% endif %}

/* Monotonic time: seconds, or ticks that wrap if numbers are float. */
#if LOOPSCOPE_FLOAT
typedef uint32_t {{ prefix }}_clock;
#else
typedef double {{ prefix }}_clock;
#endif

typedef LOOPSCOPE_REAL {{ prefix }}_real;

/* Range of the internal clock (s). */
#if LOOPSCOPE_FLOAT
#define {{ PREFIX }}_CLOCK_SECS (({{ prefix }}_real)(2147483647 / LOOPSCOPE_TICKS_PER_SECOND))
#else
#define {{ PREFIX }}_CLOCK_SECS {{ leap_secs|number }}
#endif

/* The coefficients. */
typedef struct {
    {{ prefix }}_real centre[{{ n_gauges }}];                        /* is subtracted from the gauges */
    {{ prefix }}_real conventional[{{ n_axes }}][{{ n_gauges }}];
    {{ prefix }}_real conventional_base[{{ n_axes }}];
    {{ prefix }}_real unloaded[{{ n_gauges }}];                      /* tared gauges of the unloaded sensor */
    {{ prefix }}_real limit[{{ n_axes }}];                           /* load beyond which the sensor was not tested */
{% if gauge_low %}
    {{ prefix }}_real gauge_low[{{ n_gauges }}];                     /* values at which a gauge is clipped */
    {{ prefix }}_real gauge_high[{{ n_gauges }}];
{% endif %}
    {{ prefix }}_real gap_secs;
{% if ring %}
    {{ prefix }}_clock window;
    {{ prefix }}_clock history_step;
{% endif %}
{% if look_backs %}
    {{ prefix }}_real measured_weight[{{ measured|length }}];             /* factors of the axes in the distance for F_th */
    int measured_axis[{{ measured|length }}];
    {{ prefix }}_real f_th_squared[{{ look_backs|length }}];
    {{ prefix }}_clock t_th[{{ look_backs|length }}];
{% endif %}
{% for block in blocks %}
{% for constant in block.source.constants %}
    {{ kinds[constant.precision] }} {{ constant.name }}[{{ constant.numbers|length }}]{{ "[" ~ n_gauges ~ "]" if constant.numbers[0] is sequence else "" }};
{% endfor %}
{% endfor %}
{% if linear %}
    {{ prefix }}_real linear[{{ n_axes }}][{{ n_columns }}];
    {{ prefix }}_real linear_base[{{ n_axes }}];
{% endif %}
{% if learned %}
    {{ prefix }}_real input_factor[{{ n_columns }}];
    {{ prefix }}_real input_constant[{{ n_columns }}];
{% endif %}
{% if network %}
{% for layer in layers %}
    float weights_{{ loop.index0 }}[{{ layer.weights|length }}];                      /* one row for each input */
    float biases_{{ loop.index0 }}[{{ layer.biases|length }}];
{% endfor %}
    {{ prefix }}_real target_scale[{{ n_axes }}];
    {{ prefix }}_real target_shift[{{ n_axes }}];
{% endif %}
{% if kernel %}
    {{ prefix }}_real landmarks[{{ kernel.landmarks|length }}][{{ n_columns }}];
    {{ prefix }}_real kernel_weights[{{ n_axes }}][{{ kernel.landmarks|length }}];
    {{ prefix }}_real kernel_offset[{{ n_axes }}];
    {{ prefix }}_real kernel_factor;
{% endif %}
} {{ prefix }}_calibration;

/* Status of a sample: a sum of flags. */
typedef int {{ prefix }}_status;
enum {
    {{ PREFIX }}_OK = 0,
{% for name, bits in flags %}
    {{ PREFIX }}_{{ name }} = {{ bits }}{{ "" if loop.last else "," }}
{% endfor %}
};
#define {{ PREFIX }}_IS_REJECTED(status) ((status) >= {{ PREFIX }}_REJECTED_TIME)

/* State between samples. */
typedef struct {
    double time;                                   /* time of the last accepted sample (s) */
    double wrapped;                                /* time to be added because a counter has wrapped (s) */
    uint32_t ticks;                                /* time of the last accepted sample (ticks) */
    {{ prefix }}_clock clock;                      /* the same time on the internal clock of the history */
    int started;
    {{ prefix }}_real missing;                              /* error by unknown states of the blocks; 1 is the limit of OK */
{% if fades %}
    {{ prefix }}_real unknown;                              /* by how much the load still fades; 0 if all states are known */
    {{ prefix }}_real share;                                /* share of the compensated load; the rest is conventional */
{% endif %}
    int strays;                                    /* number of successive samples with an implausible time */
    {{ prefix }}_real skipped;                     /* seconds of rejected samples since the last accepted sample; negative if unknown */
    {{ prefix }}_real load[{{ n_axes }}];
    {{ prefix }}_real conventional[{{ n_axes }}];
    {{ prefix }}_real load_zero[{{ n_axes }}];
    {{ prefix }}_real conventional_zero[{{ n_axes }}];
    {{ prefix }}_real gauge_zero[{{ n_gauges }}];
{% if ring %}
    {{ prefix }}_clock since;                      /* time when the history began */
    int is_filling;                                /* 1 while the history is shorter than the window */
    {{ prefix }}_clock last_kept;
    int newest_stays;
    int32_t newest;                                /* index of the newest sample */
    int32_t kept;                                  /* number of stored samples */
    {{ prefix }}_clock times[{{ PREFIX }}_RING];
    {{ prefix }}_real gauges[{{ PREFIX }}_RING][{{ n_gauges }}];
{% endif %}
{% if look_backs %}
    {{ prefix }}_real points[{{ measured|length }}][{{ PREFIX }}_RING];
    {{ prefix }}_real small_boxes[{{ PREFIX }}_RING / 16][2 * {{ measured|length }}];    /* minimum, maximum over 16 samples */
    {{ prefix }}_real large_boxes[{{ PREFIX }}_RING / 256][2 * {{ measured|length }}];   /* minimum, maximum over 256 samples */
{% endif %}
{% for block in blocks %}
{% for memory in block.source.memory %}
    {{ kinds[memory.precision] }} {{ memory.name }}[{{ memory.sets }}]{{ "[" ~ n_gauges ~ "]" if memory.of_gauges else "" }};{{ " /* " ~ memory.comment ~ " */" if memory.comment else "" }}
{% endfor %}
{% endfor %}
} {{ prefix }}_state;

static const {{ prefix }}_calibration {{ PREFIX }}_CALIBRATION = {
    {{ centre|numbers }},
    {{ conventional.matrix|rows }},
    {{ conventional.base|numbers }},
    {{ unloaded|numbers }},
    {{ limits|numbers }},
{% if gauge_low %}
    {{ gauge_low|numbers }},
    {{ gauge_high|numbers }},
{% endif %}
    {{ gap_secs|number }},
{% if ring %}
    {{ window_secs|time }},
    {{ history_step_secs|time }},
{% endif %}
{% if look_backs %}
    {{ measured|map(attribute=1)|numbers }},
    {{ measured|map(attribute=0)|indices }},
    {{ look_backs|map(attribute=0)|numbers }},
    {{ look_backs|map(attribute=1)|times }},
{% endif %}
{% for block in blocks %}
{% for constant in block.source.constants %}
    {{ constant.numbers|rows if constant.numbers[0] is sequence else constant.numbers|times if constant.precision == "clock" else constant.numbers|numbers }},
{% endfor %}
{% endfor %}
{% if linear %}
    {{ linear.matrix|rows }},
    {{ linear.base|numbers }},
{% endif %}
{% if learned %}
    {{ learned.inputs|map(attribute=0)|numbers }},
    {{ learned.inputs|map(attribute=1)|numbers }},
{% endif %}
{% if network %}
{% for layer in layers %}
    {{ layer.weights|weights }},
    {{ layer.biases|weights }},
{% endfor %}
    {{ network.target_scale|numbers }},
    {{ network.target_shift|numbers }},
{% endif %}
{% if kernel %}
    {{ kernel.landmarks|rows }},
    {{ kernel.weights|rows }},
    {{ kernel.offset|numbers }},
    {{ kernel_factor|number }},
{% endif %}
};

static inline int {{ prefix }}_is_finite({{ prefix }}_real x)
{
#if LOOPSCOPE_FLOAT
    return x >= -FLT_MAX && x <= FLT_MAX;
#else
    return x >= -DBL_MAX && x <= DBL_MAX;
#endif
}

static inline {{ prefix }}_real {{ prefix }}_exp({{ prefix }}_real x)
{
#if LOOPSCOPE_FLOAT
    return expf(x);
#else
    return exp(x);
#endif
}

static inline {{ prefix }}_real {{ prefix }}_expm1({{ prefix }}_real x)
{
#if LOOPSCOPE_FLOAT
    return expm1f(x);
#else
    return expm1(x);
#endif
}

/* Clears the history. Each block starts anew with the next sample. */
static inline void {{ prefix }}_forget({{ prefix }}_state *s)
{
{% if ring %}
    s->kept = 0;
{% endif %}
    s->started = 0;
    s->strays = 0;
    s->skipped = 0;
}

/* Clears the history, the tare and the zero load. */
static inline void {{ prefix }}_init({{ prefix }}_state *s)
{
    memset(s, 0, sizeof *s);
}

/*
 * Tares: subtracts these gauges from now on, the mean of several samples of the unloaded sensor. Restarts the history.
 * The load of {{ prefix }}_zero_last_load is no longer subtracted. Does nothing if a value is not finite.
 */
static inline void {{ prefix }}_tare(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, const {{ prefix }}_real mean[{{ n_gauges }}])
{
    int g;
    for (g = 0; g < {{ n_gauges }}; g++)
        if (!{{ prefix }}_is_finite(mean[g]))
            return;
    for (g = 0; g < {{ n_gauges }}; g++)
        s->gauge_zero[g] = mean[g] - c->unloaded[g];
    for (g = 0; g < {{ n_axes }}; g++)
        s->load_zero[g] = s->conventional_zero[g] = 0;
    {{ prefix }}_forget(s);
}

/* From now on, subtracts the load of the last sample that was not rejected, including the noise of that
 * sample. To tare gauges, use {{ prefix }}_tare. The history is kept. */
static inline void {{ prefix }}_zero_last_load({{ prefix }}_state *s)
{
    int axis;
    for (axis = 0; axis < {{ n_axes }}; axis++) {
        s->load_zero[axis] = s->load[axis];
        s->conventional_zero[axis] = s->conventional[axis];
    }
}

static inline {{ prefix }}_real {{ prefix }}_dot(const {{ prefix }}_real *a, const {{ prefix }}_real *b, int n)
{
    {{ prefix }}_real sum = 0;
    int i;
    for (i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/* Returns 1 if all gauges{{ " and auxiliary channels" if auxiliary }} are finite numbers. */
static inline int {{ prefix }}_are_good(const {{ prefix }}_real *gauges{{ ", const " ~ prefix ~ "_real *auxiliary" if auxiliary }})
{
    int g;
{% if auxiliary %}
    for (g = 0; g < {{ n_auxiliary }}; g++)
        if (!{{ prefix }}_is_finite(auxiliary[g]))
            return 0;
{% endif %}
    for (g = 0; g < {{ n_gauges }}; g++)
        if (!{{ prefix }}_is_finite(gauges[g]))
            return 0;
    return 1;
}

/* Returns the status of a sample with an implausible time. */
static inline {{ prefix }}_status {{ prefix }}_stray({{ prefix }}_state *s)
{
    s->strays += 1;
    return s->strays < {{ strays }} ? {{ PREFIX }}_REJECTED_TIME : {{ PREFIX }}_RESTARTED;
}

/* Returns the status of a sample by the seconds since the last sample. A time beyond the range of the clock is a gap. */
static inline {{ prefix }}_status {{ prefix }}_after(const {{ prefix }}_calibration *c, {{ prefix }}_real secs)
{
    return secs > c->gap_secs || secs > {{ PREFIX }}_CLOCK_SECS ? {{ PREFIX }}_AFTER_GAP : {{ PREFIX }}_OK;
}
{% if look_backs %}

static inline void {{ prefix }}_widen({{ prefix }}_real *box, const {{ prefix }}_real *point, int is_first)
{
    int i;
    for (i = 0; i < {{ measured|length }}; i++) {
        if (is_first || point[i] < box[2 * i])
            box[2 * i] = point[i];
        if (is_first || point[i] > box[2 * i + 1])
            box[2 * i + 1] = point[i];
    }
}

/* Returns the squared distance to the farthest corner of a box, an upper bound for all samples of the box. */
static inline {{ prefix }}_real {{ prefix }}_farthest(const {{ prefix }}_real *box, const {{ prefix }}_real *point)
{
    {{ prefix }}_real sum = 0;
    int i;
    for (i = 0; i < {{ measured|length }}; i++) {
        {{ prefix }}_real low = point[i] - box[2 * i], high = box[2 * i + 1] - point[i];
        {{ prefix }}_real reach = low > high ? low : high;
        sum += reach * reach;
    }
    return sum;
}

/* Returns the last of 16 samples that differs by F_th, or -1. The loop has no branch, so that the compiler can vectorise it. */
static inline int32_t {{ prefix }}_last_far(const {{ prefix }}_state *s, int32_t start, const {{ prefix }}_real *point, {{ prefix }}_real f_th_squared)
{
    {{ prefix }}_real squares[16] = {0};
    int i, lane;
    for (i = 0; i < {{ measured|length }}; i++) {
        const {{ prefix }}_real *values = s->points[i] + start;
        for (lane = 0; lane < 16; lane++) {
            {{ prefix }}_real d = values[lane] - point[i];
            squares[lane] += d * d;
        }
    }
    for (lane = 15; lane >= 0; lane--)
        if (squares[lane] >= f_th_squared)
            return start + lane;
    return -1;
}

/* Look-back: returns, from the newest sample backwards, the first sample that differs by F_th and is no older than t_th, or else
 * the newest sample. */
static inline int32_t {{ prefix }}_past(const {{ prefix }}_state *s, {{ prefix }}_real f_th_squared, {{ prefix }}_clock t_th)
{
    {{ prefix }}_real point[{{ measured|length }}];
    {{ prefix }}_clock now = s->times[s->newest];
    int32_t end = s->newest + 1, left = s->kept;
    int i;
    for (i = 0; i < {{ measured|length }}; i++)
        point[i] = s->points[i][s->newest];
    while (left > 0) {
        int32_t step = 1, found = -1;
        if (end == 0)
            end = {{ PREFIX }}_RING;
        if (now - s->times[end - 1] > t_th)
            break;
        /* The large box that is being overwritten has lost its older samples. */
        if (end % 256 == 0 && (end / 256 != s->newest / 256 + 1 || end == s->newest + 1)
            && {{ prefix }}_farthest(s->large_boxes[end / 256 - 1], point) < f_th_squared) {
            step = 256;
        } else if (end % 16 == 0) {
            step = 16;
            if ({{ prefix }}_farthest(s->small_boxes[end / 16 - 1], point) >= f_th_squared)
                found = {{ prefix }}_last_far(s, end - 16, point, f_th_squared);
        } else {
            {{ prefix }}_real sum = 0;
            for (i = 0; i < {{ measured|length }}; i++) {
                {{ prefix }}_real d = s->points[i][end - 1] - point[i];
                sum += d * d;
            }
            if (sum >= f_th_squared)
                found = end - 1;
        }
        if (found >= 0)
            return now - s->times[found] <= t_th ? found : s->newest;
        end -= step;
        left -= step;
    }
    return s->newest;
}
{% endif %}
{% if ring %}

/* Returns the index of the sample that is `back` samples older than the newest. */
static inline int32_t {{ prefix }}_slot(const {{ prefix }}_state *s, int32_t back)
{
    return s->newest >= back ? s->newest - back : s->newest - back + {{ PREFIX }}_RING;
}

/* Stores the sample, in place of the previous sample if that one came too soon. In a full ring, the oldest box is
 * overwritten. */
static inline void {{ prefix }}_keep(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, const {{ prefix }}_real *centred)
{
    int i;
    if (s->kept == 0) {
        s->newest = 0;
        s->kept = 1;
    } else if (s->newest_stays) {
        s->newest = s->newest + 1 == {{ PREFIX }}_RING ? 0 : s->newest + 1;
        if (s->newest % 16 == 0 && s->kept > {{ PREFIX }}_RING - 16)
            s->kept = {{ PREFIX }}_RING - 16;
        s->kept += 1;
    }
    s->newest_stays = s->kept == 1 || s->clock - s->last_kept >= c->history_step;
    if (s->newest_stays)
        s->last_kept = s->clock;
    s->times[s->newest] = s->clock;
    for (i = 0; i < {{ n_gauges }}; i++)
        s->gauges[s->newest][i] = centred[i];
{% if look_backs %}
    {
        {{ prefix }}_real point[{{ measured|length }}];
        for (i = 0; i < {{ measured|length }}; i++) {
            point[i] = s->conventional[c->measured_axis[i]] * c->measured_weight[i];
            s->points[i][s->newest] = point[i];
        }
        /* A sample that will be replaced is the newest until then, so no search needs it in a box. */
        if (s->newest_stays || s->newest % 16 == 0) {
            {{ prefix }}_widen(s->small_boxes[s->newest / 16], point, s->newest % 16 == 0);
            {{ prefix }}_widen(s->large_boxes[s->newest / 256], point, s->newest % 256 == 0);
        }
    }
{% endif %}
    /* Drops samples that are too old to be used, before the wrapping clock makes them look new. A lag needs one older sample. */
    while (s->kept > 2 && s->clock - s->times[{{ prefix }}_slot(s, s->kept - 2)] > c->window)
        s->kept -= 1;
}
{% endif %}
{% for block in blocks if block.source.c.functions %}

{{ block.source.c.functions|filled(block.sets) }}
{% endfor %}
{% if network %}

/* Computes one layer. Weights are stored by input, so that the compiler can vectorise over outputs. */
static inline void {{ prefix }}_layer(const float *weights, const float *biases, int n_inputs, int n_outputs, int is_rectified,
                                const {{ prefix }}_real *in, {{ prefix }}_real *out)
{
    int i, o;
    for (o = 0; o < n_outputs; o++)
        out[o] = ({{ prefix }}_real)biases[o];
    for (i = 0; i < n_inputs; i++) {
        const float *row = weights + (size_t)i * (size_t)n_outputs;
        {{ prefix }}_real x = in[i];
        for (o = 0; o < n_outputs; o++)
            out[o] += x * ({{ prefix }}_real)row[o];
    }
    for (o = 0; is_rectified && o < n_outputs; o++)
        out[o] = out[o] > 0 ? out[o] : 0;
}
{% endif %}

/* Processes a sample whose status is known, `dt` seconds after the last sample. */
static inline {{ prefix }}_status {{ prefix }}_run(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, {{ prefix }}_status status,
                                          {{ prefix }}_real dt, const {{ prefix }}_real *gauges,{{ " const " ~ prefix ~ "_real *auxiliary," if auxiliary }} {{ prefix }}_real *load,
                                          {{ prefix }}_real *conventional)
{
    int axis;
    if ({{ PREFIX }}_IS_REJECTED(status)) {
        for (axis = 0; axis < {{ n_axes }}; axis++) {
            load[axis] = ({{ prefix }}_real)NAN;
            if (conventional != NULL)
                conventional[axis] = ({{ prefix }}_real)NAN;
        }
        return status;
    }
    s->strays = 0;
    s->skipped = 0;
    if (status == {{ PREFIX }}_RESTARTED || dt > {{ PREFIX }}_CLOCK_SECS)
        {{ prefix }}_forget(s);
    if (!s->started)
        dt = 0;
    s->missing = 0;
{% if fades %}
    s->unknown = 0;
    if (!s->started)
        s->share = 1;
{% endif %}
{% if ring %}
    if (dt > {{ stored_keep_secs|number }})
        s->kept = 0;
    if (!s->started || status != {{ PREFIX }}_OK) {
        s->since = s->clock;
        s->is_filling = 1;
    }
    if (s->clock - s->since >= c->window)
        s->is_filling = 0;
{% endif %}
    {
        {{ prefix }}_real row[{{ n_columns }}];
        int g;
{% if n_columns > n_gauges %}
        {{ prefix }}_real *next = row + {{ n_gauges }};
{% endif %}
        for (g = 0; g < {{ n_gauges }}; g++)
            row[g] = (gauges[g] - s->gauge_zero[g]) - c->centre[g];
        for (axis = 0; axis < {{ n_axes }}; axis++)
            s->conventional[axis] = c->conventional_base[axis] + {{ prefix }}_dot(c->conventional[axis], row, {{ n_gauges }});
{% if ring %}
        {{ prefix }}_keep(c, s, row);
{% endif %}
{% if look_backs %}
        {
            int at;
            for (at = 0; at < {{ look_backs|length }}; at++) {
                int32_t past = {{ prefix }}_past(s, c->f_th_squared[at], c->t_th[at]);
                for (g = 0; g < {{ n_gauges }}; g++)
                    *next++ = s->gauges[past][g] - row[g];
            }
        }
{% endif %}
{% for block in blocks %}
        {
{% if "started" in block.source.c.update %}
            int started = s->started && dt <= {{ block.keep_secs|number }};
{% endif %}
{{ block.source.c.update|filled(block.sets) }}
        }
{% endfor %}
        for (axis = 0; axis < {{ n_axes }}; axis++) {
{% if linear %}
            s->load[axis] = c->linear_base[axis] + {{ prefix }}_dot(c->linear[axis], row, {{ n_columns }});
{% endif %}
{% if not linear %}
            s->load[axis] = 0;
{% endif %}
        }
{% if learned %}
        {
            int column;
            for (column = 0; column < {{ n_columns }}; column++)
                row[column] = row[column] * c->input_factor[column] + c->input_constant[column];
        }
{% endif %}
{% if network %}
        {
            {{ prefix }}_real values[2][{{ widest }}];
            int input;
            for (input = 0; input < {{ n_columns }}; input++)
                values[0][input] = row[input];
{% for layer in layers %}
            {{ prefix }}_layer(c->weights_{{ loop.index0 }}, c->biases_{{ loop.index0 }}, {{ layer.inputs }}, {{ layer.biases|length }}, {{ 0 if loop.last else 1 }}, values[{{ loop.index0 % 2 }}], values[{{ (loop.index0 + 1) % 2 }}]);
{% endfor %}
            for (axis = 0; axis < {{ n_axes }}; axis++)
                s->load[axis] += c->target_shift[axis] + c->target_scale[axis] * values[{{ layers|length % 2 }}][axis];
        }
{% endif %}
{% if kernel %}
        {
            int landmark;
            for (axis = 0; axis < {{ n_axes }}; axis++)
                s->load[axis] += c->kernel_offset[axis];
            for (landmark = 0; landmark < {{ kernel.landmarks|length }}; landmark++) {
                {{ prefix }}_real squares = 0, similarity;
                int column;
                for (column = 0; column < {{ n_columns }}; column++) {
                    {{ prefix }}_real d = row[column] - c->landmarks[landmark][column];
                    squares += d * d;
                }
                similarity = {{ prefix }}_exp(c->kernel_factor * squares);
                for (axis = 0; axis < {{ n_axes }}; axis++)
                    s->load[axis] += c->kernel_weights[axis][landmark] * similarity;
            }
        }
{% endif %}
{% if fades %}
        {
            {{ prefix }}_real share = 1 / (1 + s->unknown * s->unknown);
            {{ prefix }}_real most = s->share + ({{ prefix }}_real){{ most_rise }};
            s->share = share > most ? most : share;
        }
        for (axis = 0; axis < {{ n_axes }}; axis++)
            s->load[axis] = s->conventional[axis] + s->share * (s->load[axis] - s->conventional[axis]);
{% endif %}
        (void)dt;
        s->started = 1;
    }
    if ({{ "s->is_filling || " if ring }}s->missing > 1)
        status |= {{ PREFIX }}_FILLING;
{% if auxiliary %}
    for (axis = 0; axis < {{ n_auxiliary }}; axis++)
        if (auxiliary[axis] < c->auxiliary_low[axis] || auxiliary[axis] > c->auxiliary_high[axis])
            status |= {{ PREFIX }}_BEYOND;
{% endif %}
{% if gauge_low %}
    for (axis = 0; axis < {{ n_gauges }}; axis++) {
        {{ prefix }}_real gauge = gauges[axis]{{ " - s->gauge_zero[axis]" if limits_tared }};
        if (gauge <= c->gauge_low[axis] || gauge >= c->gauge_high[axis])
            status |= {{ PREFIX }}_BEYOND;
    }
{% endif %}
    for (axis = 0; axis < {{ n_axes }}; axis++) {
        if (s->load[axis] > c->limit[axis] || s->load[axis] < -c->limit[axis])
            status |= {{ PREFIX }}_BEYOND;
        load[axis] = s->load[axis] - s->load_zero[axis];
        if (conventional != NULL)
            conventional[axis] = s->conventional[axis] - s->conventional_zero[axis];
    }
    return status;
}

/*
 * Processes the next sample at `time` (s). Writes the load, and the conventional load (from the present gauges alone) unless
 * its pointer is NULL. Both loads are NaN if the sample is rejected.
 */
static inline {{ prefix }}_status {{ prefix }}_update(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, double time,
                                             const {{ prefix }}_real gauges[{{ n_gauges }}],{{ " const " ~ prefix ~ "_real auxiliary[" ~ n_auxiliary ~ "]," if auxiliary }} {{ prefix }}_real load[{{ n_axes }}],
                                             {{ prefix }}_real conventional[{{ n_axes }}])
{
    {{ prefix }}_status status = {{ PREFIX }}_OK;
    double step = 0;
    if (!{{ prefix }}_are_good(gauges{{ ", auxiliary" if auxiliary }}) || !(time >= -DBL_MAX && time <= DBL_MAX)) {
        status = {{ PREFIX }}_REJECTED_VALUE;
    } else if (s->started) {
        step = time + s->wrapped - s->time;
{% for wrap in wraps_secs %}
        if (step < 0 && step + {{ wrap|plain }} >= 0 && step + {{ wrap|plain }} <= {{ gap_secs|plain }}) {
            s->wrapped += {{ wrap|plain }};
            step += {{ wrap|plain }};
        }
{% endfor %}
        if (!(step >= 0 && step <= {{ leap_secs|plain }})) {
            status = {{ prefix }}_stray(s);
            step = 0;
            if (status == {{ PREFIX }}_RESTARTED)
                s->wrapped = 0;
        } else {
            status = {{ prefix }}_after(c, ({{ prefix }}_real)step);
        }
    }
    if (!{{ PREFIX }}_IS_REJECTED(status)) {
        s->time = time + s->wrapped;
#if LOOPSCOPE_FLOAT
        if (({{ prefix }}_real)step <= {{ PREFIX }}_CLOCK_SECS)
            s->clock += (uint32_t)(step * LOOPSCOPE_TICKS_PER_SECOND + 0.5);
#else
        s->clock = s->time;
#endif
    }
    return {{ prefix }}_run(c, s, status, ({{ prefix }}_real)step, gauges{{ ", auxiliary" if auxiliary }}, load, conventional);
}

/*
 * Like update, with a 32-bit counter as time. A difference in the last 1/64 of the counter's range (67 s in microseconds) counts as
 * a time before the last sample, any other difference as a time after it.
 */
static inline {{ prefix }}_status {{ prefix }}_update_ticks(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, uint32_t ticks,
                                                   const {{ prefix }}_real gauges[{{ n_gauges }}],{{ " const " ~ prefix ~ "_real auxiliary[" ~ n_auxiliary ~ "]," if auxiliary }} {{ prefix }}_real load[{{ n_axes }}],
                                                   {{ prefix }}_real conventional[{{ n_axes }}])
{
    {{ prefix }}_status status = {{ PREFIX }}_OK;
    int is_good = {{ prefix }}_are_good(gauges{{ ", auxiliary" if auxiliary }});
    uint32_t step = 0;
    {{ prefix }}_real dt = 0;
    if (s->started)
        step = ticks - s->ticks;
    if (step > 0xfbffffffu) {
        step = 0;
        if (is_good)
            status = {{ prefix }}_stray(s);
    } else {
        /* A pause is detected even if the counter wraps while samples are rejected. */
        dt = ({{ prefix }}_real)step / (({{ prefix }}_real)LOOPSCOPE_TICKS_PER_SECOND);
        s->skipped = dt = dt > s->skipped ? dt : s->skipped;
        status = {{ prefix }}_after(c, dt);
    }
    if (!is_good)
        status = {{ PREFIX }}_REJECTED_VALUE;
    if (!{{ PREFIX }}_IS_REJECTED(status)) {
        s->ticks = ticks;
#if LOOPSCOPE_FLOAT
        s->clock += step;
#else
        s->clock += step / (1.0 * LOOPSCOPE_TICKS_PER_SECOND);
#endif
    }
    return {{ prefix }}_run(c, s, status, dt, gauges{{ ", auxiliary" if auxiliary }}, load, conventional);
}

/*
 * Like update, with the seconds since the last call, zero or more. The first call ignores them. A sample with an invalid step is
 * rejected. The elapsed time is then unknown, so the next sample restarts the history.
 */
static inline {{ prefix }}_status {{ prefix }}_update_step(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, {{ prefix }}_real dt,
                                                  const {{ prefix }}_real gauges[{{ n_gauges }}],{{ " const " ~ prefix ~ "_real auxiliary[" ~ n_auxiliary ~ "]," if auxiliary }} {{ prefix }}_real load[{{ n_axes }}],
                                                  {{ prefix }}_real conventional[{{ n_axes }}])
{
    {{ prefix }}_status status = {{ PREFIX }}_OK;
    int is_known = s->skipped >= 0;
    if (is_known)
        s->skipped = dt >= 0 ? s->skipped + dt : -1;
    if (!{{ prefix }}_are_good(gauges{{ ", auxiliary" if auxiliary }}) || !{{ prefix }}_is_finite(dt))
        status = {{ PREFIX }}_REJECTED_VALUE;
    else if (!s->started)
        s->skipped = 0;
    else if (!(dt >= 0))
        status = {{ prefix }}_stray(s);
    else
        status = is_known ? {{ prefix }}_after(c, s->skipped) : {{ PREFIX }}_RESTARTED;
    dt = status == {{ PREFIX }}_RESTARTED ? 0 : s->skipped;
    if (!{{ PREFIX }}_IS_REJECTED(status) && dt <= {{ PREFIX }}_CLOCK_SECS) {
#if LOOPSCOPE_FLOAT
        s->clock += (uint32_t)(dt * LOOPSCOPE_TICKS_PER_SECOND + 0.5f);
#else
        s->clock += dt;
#endif
    }
    return {{ prefix }}_run(c, s, status, dt, gauges{{ ", auxiliary" if auxiliary }}, load, conventional);
}

#ifdef __cplusplus
}

/*
 * The calibration as a class, for C++11 and later:
 *
 *     static {{ prefix }}_estimator estimator;
 *     for each sample:
 *         const auto status = estimator.update(seconds, gauges{{ ", auxiliary" if auxiliary }});
 *         if (!{{ prefix }}_estimator::is_rejected(status)) its load is estimator.load()
 *
 * The object contains its whole state, so do not put it on a small stack. It does not allocate, throw or lock; if threads share
 * it, the caller has to lock.
 */
class {{ prefix }}_estimator {
public:
    typedef {{ prefix }}_real real;
    typedef real loads[{{ n_axes }}];

    /* Status of a sample, as above: a sum of these flags. */
    enum class status : int {
        ok = {{ PREFIX }}_OK,
{% for name, _ in flags %}
        {{ name|lower }} = {{ PREFIX }}_{{ name }}{{ "" if loop.last else "," }}
{% endfor %}
    };

    static bool has(status of_sample, status flag) noexcept
    {
        return (static_cast<int>(of_sample) & static_cast<int>(flag)) != 0;
    }
    static bool is_rejected(status of_sample) noexcept { return of_sample >= status::rejected_time; }

    explicit {{ prefix }}_estimator(const {{ prefix }}_calibration &calibration = {{ PREFIX }}_CALIBRATION) noexcept
        : calibration_(calibration), state_(), load_(), conventional_()
    {
        for (int axis = 0; axis < {{ n_axes }}; axis++)
            load_[axis] = conventional_[axis] = static_cast<real>(NAN);
    }

    /* Each update processes the next sample of {{ n_gauges }} gauges. Use one kind of time: seconds on any clock, a counter
     * of 32 bits, or seconds since the last call. */
    status update(double seconds, const real *gauges{{ ", const real *auxiliary" if auxiliary }}) noexcept
    {
        return static_cast<status>({{ prefix }}_update(&calibration_, &state_, seconds, gauges{{ ", auxiliary" if auxiliary }}, load_, conventional_));
    }
    status update_ticks(uint32_t ticks, const real *gauges{{ ", const real *auxiliary" if auxiliary }}) noexcept
    {
        return static_cast<status>({{ prefix }}_update_ticks(&calibration_, &state_, ticks, gauges{{ ", auxiliary" if auxiliary }}, load_, conventional_));
    }
    status update_step(real seconds, const real *gauges{{ ", const real *auxiliary" if auxiliary }}) noexcept
    {
        return static_cast<status>({{ prefix }}_update_step(&calibration_, &state_, seconds, gauges{{ ", auxiliary" if auxiliary }}, load_, conventional_));
    }

    /* Conventional load of the last sample, from its gauges alone; NaN before the first sample and for a rejected sample. */
    const loads &load() const noexcept { return load_; }
    const loads &conventional() const noexcept { return conventional_; }

    /* Tares by the mean of several samples of the unloaded sensor; restarts the history. */
    void tare(const real *mean) noexcept { {{ prefix }}_tare(&calibration_, &state_, mean); }
    /* Subtracts the load of the last accepted sample from now on, including its noise. */
    void zero_last_load() noexcept { {{ prefix }}_zero_last_load(&state_); }
    /* Clears the history, the tare and the zero load. */
    void reset() noexcept { {{ prefix }}_init(&state_); }

private:
    const {{ prefix }}_calibration &calibration_;
    {{ prefix }}_state state_;
    loads load_, conventional_;
};
#endif

#endif

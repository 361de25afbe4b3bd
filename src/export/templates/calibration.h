{% set kinds = {"real": prefix ~ "_real", "double": "double", "index": "long"} %}
/*
 * A calibration of a force/torque sensor: gauges in, load out, one sample at a time.
 *
{% for fact in facts %}
 * {{ fact|comment }}
{% endfor %}
 *
 * Use: one state for each sensor, static since it may be large.
 *
 *     static {{ prefix }}_state state;
 *     {{ prefix }}_init(&state);
 *     for each sample:
 *         {{ prefix }}_update(&{{ PREFIX }}_CALIBRATION, &state, time, gauges, load, NULL);
 *
 * Gauges stand in the order above and in the unit of the training recordings, time in seconds on any clock; loads stand in
 * the order and units above. The first sample after init starts relaxed: nothing has happened before it.
 *
 * Update says what became of the sample:
 *     {{ PREFIX }}_OK         the load is that of this sample.
 *     {{ PREFIX }}_RESTARTED  so it is, but the history starts anew with it, as after init; the zero of bias is kept.
 *     {{ PREFIX }}_REJECTED   there is no load but NaN, and nothing is remembered of the sample: a number in it is not
 *                          finite, or its time is before the last or more than {{ leap_secs|number }} s after it. After
 *                          {{ strays }} such times in a row the clock counts as set anew: the last of them restarts. The
 *                          same time again is no time gone by.
 *
 * LOOPSCOPE_REAL is the type of the numbers: double, or float if you define it so.
{% if ring %}
 * LOOPSCOPE_RATE_HZ is the fastest rate of samples, a whole number: {{ rate_hz }} unless you define it. The past that the blocks
 * need, {{ window_secs|number }} s, must fit the ring of {{ PREFIX }}_RING samples; if samples come faster the oldest are lost, and the
 * answer is that of a shorter t_th or of a lag that has not yet passed.
{% endif %}
 * Both must be the same wherever this file is included.
 *
 * Memory of the state: about {{ bytes_double }} bytes in double, {{ bytes_float }} in float{% if ring %} at {{ rate_hz }} Hz{% endif %}.
 * Cost of an update: {{ products }} multiplications{{ search_cost }}, whatever the sample; no heap, no recursion.
{% if look_backs %}
 * In float a load that just touches F_th may find another past sample than in double.
{% endif %}
 */
#ifndef {{ PREFIX }}_H
#define {{ PREFIX }}_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LOOPSCOPE_REAL
#define LOOPSCOPE_REAL double
#endif
{% if ring %}
#ifndef LOOPSCOPE_RATE_HZ
#define LOOPSCOPE_RATE_HZ {{ rate_hz }}
#endif
{% endif %}

#define {{ PREFIX }}_GAUGES {{ n_gauges }}
#define {{ PREFIX }}_AXES {{ n_axes }}
/* Gauges and what the blocks append. */
#define {{ PREFIX }}_COLUMNS {{ n_columns }}
{% if ring %}
#define {{ PREFIX }}_WINDOW_MS {{ window_ms }}LL
/* Samples in the window with a sixteenth to spare, and a box that is being written over; whole boxes. */
#define {{ PREFIX }}_IN_WINDOW (({{ PREFIX }}_WINDOW_MS * (LOOPSCOPE_RATE_HZ) + 999) / 1000)
#define {{ PREFIX }}_BOXES (({{ PREFIX }}_IN_WINDOW * 17 / 16 + 2 + 255) / 256 + 1)
#define {{ PREFIX }}_RING ({{ PREFIX }}_BOXES * 256)
{% endif %}

typedef LOOPSCOPE_REAL {{ prefix }}_real;

/* The coefficients. */
typedef struct {
    {{ prefix }}_real centre[{{ n_gauges }}];                        /* gauges count from here */
    {{ prefix }}_real conventional[{{ n_axes }}][{{ n_gauges }}];
    {{ prefix }}_real conventional_base[{{ n_axes }}];
{% if look_backs %}
    {{ prefix }}_real measured_weight[{{ measured|length }}];             /* of the axes that F_th is measured on */
    int measured_axis[{{ measured|length }}];
    {{ prefix }}_real f_th_squared[{{ look_backs|length }}];
    double t_th_secs[{{ look_backs|length }}];
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

/* What became of a sample. */
typedef enum {
    {{ PREFIX }}_OK,
    {{ PREFIX }}_RESTARTED,
    {{ PREFIX }}_REJECTED
} {{ prefix }}_status;

/* What is remembered between samples. */
typedef struct {
    int started;
    int strays;                                    /* so many samples in a row were off the clock */
    double time;                                   /* of the last good sample, and its loads */
    {{ prefix }}_real load[{{ n_axes }}];
    {{ prefix }}_real conventional[{{ n_axes }}];
    {{ prefix }}_real load_zero[{{ n_axes }}];
    {{ prefix }}_real conventional_zero[{{ n_axes }}];
{% if ring %}
    long newest;                                   /* where the newest sample stands, and how many are kept */
    long kept;
    double times[{{ PREFIX }}_RING];
    {{ prefix }}_real gauges[{{ PREFIX }}_RING][{{ n_gauges }}];
{% endif %}
{% if look_backs %}
    {{ prefix }}_real points[{{ PREFIX }}_RING][{{ measured|length }}];
    {{ prefix }}_real small_boxes[{{ PREFIX }}_BOXES * 16][2 * {{ measured|length }}];    /* low, high over 16 samples */
    {{ prefix }}_real large_boxes[{{ PREFIX }}_BOXES][2 * {{ measured|length }}];         /* and over 256 */
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
{% if look_backs %}
    {{ measured|map(attribute=1)|numbers }},
    {{ measured|map(attribute=0)|indices }},
    {{ look_backs|map(attribute=0)|numbers }},
    {{ look_backs|map(attribute=1)|numbers }},
{% endif %}
{% for block in blocks %}
{% for constant in block.source.constants %}
    {{ constant.numbers|rows if constant.numbers[0] is sequence else constant.numbers|numbers }},
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

/* Forgets the past. */
static inline void {{ prefix }}_forget({{ prefix }}_state *s)
{
{% for block in blocks %}
{% for memory in block.source.memory %}
    memset(s->{{ memory.name }}, 0, sizeof s->{{ memory.name }});
{% endfor %}
{% endfor %}
{% if ring %}
    s->newest = 0;
    s->kept = 0;
{% endif %}
    s->started = 0;
    s->strays = 0;
    s->time = 0.0;
}

/* Starts anew: no past, no zero. */
static inline void {{ prefix }}_init({{ prefix }}_state *s)
{
    int axis;
    {{ prefix }}_forget(s);
    for (axis = 0; axis < {{ n_axes }}; axis++) {
        s->load[axis] = 0;
        s->conventional[axis] = 0;
        s->load_zero[axis] = 0;
        s->conventional_zero[axis] = 0;
    }
}

/* Tares: from now on the load of the last sample that was not rejected counts as zero. The past is kept. */
static inline void {{ prefix }}_bias({{ prefix }}_state *s)
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

/* What is to become of a sample; the past is forgotten if it restarts. */
static inline {{ prefix }}_status {{ prefix }}_judge({{ prefix }}_state *s, double time, const {{ prefix }}_real *gauges)
{
    int g;
    if (!isfinite(time))
        return {{ PREFIX }}_REJECTED;
    for (g = 0; g < {{ n_gauges }}; g++)
        if (!isfinite(gauges[g]))
            return {{ PREFIX }}_REJECTED;
    if (!s->started || (time >= s->time && time - s->time <= {{ leap_secs|number }})) {
        s->strays = 0;
        return {{ PREFIX }}_OK;
    }
    s->strays += 1;
    if (s->strays < {{ strays }})
        return {{ PREFIX }}_REJECTED;
    {{ prefix }}_forget(s);
    return {{ PREFIX }}_RESTARTED;
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

/* Squared distance to the farthest corner: no sample in the box is farther. */
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

/* Going back from the newest sample, the first that differs by F_th and is no older than t_th; else the newest. */
static inline long {{ prefix }}_past(const {{ prefix }}_state *s, {{ prefix }}_real f_th_squared, double t_th_secs)
{
    const {{ prefix }}_real *point = s->points[s->newest];
    double now = s->times[s->newest];
    long end = s->newest + 1, left = s->kept;
    while (left > 0) {
        long step = 1;
        if (end == 0)
            end = (long){{ PREFIX }}_RING;
        if (now - s->times[end - 1] > t_th_secs)
            break;
        if (end % 256 == 0 && {{ prefix }}_farthest(s->large_boxes[end / 256 - 1], point) < f_th_squared) {
            step = 256;
        } else if (end % 16 == 0 && {{ prefix }}_farthest(s->small_boxes[end / 16 - 1], point) < f_th_squared) {
            step = 16;
        } else {
            {{ prefix }}_real sum = 0;
            int i;
            for (i = 0; i < {{ measured|length }}; i++) {
                {{ prefix }}_real d = s->points[end - 1][i] - point[i];
                sum += d * d;
            }
            if (sum >= f_th_squared)
                return end - 1;
        }
        end -= step;
        left -= step;
    }
    return s->newest;
}
{% endif %}
{% if ring %}

/* Keeps the sample; the oldest box goes when its place is needed. */
static inline void {{ prefix }}_keep(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, double time, const {{ prefix }}_real *centred)
{
    int i;
    s->newest = s->kept == 0 || s->newest + 1 == (long){{ PREFIX }}_RING ? 0 : s->newest + 1;
    if (s->newest % 256 == 0 && s->kept > (long){{ PREFIX }}_RING - 256)
        s->kept = (long){{ PREFIX }}_RING - 256;
    s->kept += 1;
    s->times[s->newest] = time;
    for (i = 0; i < {{ n_gauges }}; i++)
        s->gauges[s->newest][i] = centred[i];
{% if look_backs %}
    for (i = 0; i < {{ measured|length }}; i++)
        s->points[s->newest][i] = s->conventional[c->measured_axis[i]] * c->measured_weight[i];
    {{ prefix }}_widen(s->small_boxes[s->newest / 16], s->points[s->newest], s->newest % 16 == 0);
    {{ prefix }}_widen(s->large_boxes[s->newest / 256], s->points[s->newest], s->newest % 256 == 0);
{% endif %}
{% if not look_backs %}
    (void)c;
{% endif %}
}
{% endif %}
{% for block in blocks if block.source.c.functions %}

{{ block.source.c.functions|filled(block.sets) }}
{% endfor %}
{% if network %}

/* One layer; weights stand input by input, so that a compiler can do many outputs at once. */
static inline void {{ prefix }}_layer(const float *weights, const float *biases, int n_inputs, int n_outputs, int is_rectified,
                                const {{ prefix }}_real *in, {{ prefix }}_real *out)
{
    int i, o;
    for (o = 0; o < n_outputs; o++)
        out[o] = biases[o];
    for (i = 0; i < n_inputs; i++) {
        const float *row = weights + (size_t)i * (size_t)n_outputs;
        {{ prefix }}_real x = in[i];
        for (o = 0; o < n_outputs; o++)
            out[o] += x * row[o];
    }
    for (o = 0; is_rectified && o < n_outputs; o++)
        out[o] = out[o] > 0 ? out[o] : 0;
}
{% endif %}

/*
 * Takes the next sample and writes its load, and its conventional load (of the present gauges alone) unless that is NULL; NaN
 * where the sample is rejected.
 */
static inline {{ prefix }}_status {{ prefix }}_update(const {{ prefix }}_calibration *c, {{ prefix }}_state *s, double time,
                                             const {{ prefix }}_real gauges[{{ n_gauges }}], {{ prefix }}_real load[{{ n_axes }}],
                                             {{ prefix }}_real conventional[{{ n_axes }}])
{
    int axis;
    {{ prefix }}_status status = {{ prefix }}_judge(s, time, gauges);
    if (status != {{ PREFIX }}_REJECTED) {
        /* Gauges less centre, then for each history gauges less the present ones, then monomials. */
        {{ prefix }}_real row[{{ n_columns }}];
        int g;
{% if n_columns > n_gauges %}
        {{ prefix }}_real *next = row + {{ n_gauges }};
{% endif %}
        for (g = 0; g < {{ n_gauges }}; g++)
            row[g] = gauges[g] - c->centre[g];
        for (axis = 0; axis < {{ n_axes }}; axis++)
            s->conventional[axis] = c->conventional_base[axis] + {{ prefix }}_dot(c->conventional[axis], row, {{ n_gauges }});
{% if ring %}
        {{ prefix }}_keep(c, s, time, row);
{% endif %}
{% if look_backs %}
        {
            int at;
            for (at = 0; at < {{ look_backs|length }}; at++) {
                long past = {{ prefix }}_past(s, c->f_th_squared[at], c->t_th_secs[at]);
                for (g = 0; g < {{ n_gauges }}; g++)
                    *next++ = s->gauges[past][g] - row[g];
            }
        }
{% endif %}
{% for block in blocks %}
        {
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
                similarity = sizeof(squares) == sizeof(float) ? ({{ prefix }}_real)expf((float)(c->kernel_factor * squares))
                                                              : ({{ prefix }}_real)exp(c->kernel_factor * squares);
                for (axis = 0; axis < {{ n_axes }}; axis++)
                    s->load[axis] += c->kernel_weights[axis][landmark] * similarity;
            }
        }
{% endif %}
        s->time = time;
        s->started = 1;
    }
    for (axis = 0; axis < {{ n_axes }}; axis++) {
        int is_good = status != {{ PREFIX }}_REJECTED;
        load[axis] = is_good ? s->load[axis] - s->load_zero[axis] : ({{ prefix }}_real)NAN;
        if (conventional != NULL)
            conventional[axis] = is_good ? s->conventional[axis] - s->conventional_zero[axis] : ({{ prefix }}_real)NAN;
    }
    return status;
}

#ifdef __cplusplus
}
#endif

#endif

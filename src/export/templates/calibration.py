# Calibration of a force/torque sensor. Computes the load from the gauges, one sample at a time. Needs NumPy.
#
{% for fact in facts %}
# {{ fact|comment }}
{% endfor %}
#
# Use:
#
#     state = State()
#     load, conventional = state.update(time, gauges{{ ", auxiliary" if auxiliary }})    # sample by sample
#     load, conventional = apply(times, gauges{{ ", auxiliary" if auxiliary }})          # a whole recording
#
{% if auxiliary %}
# Auxiliary channels, in this order and unit. A value that leaves its range by more than a tenth of the range sets the
# flag BEYOND:
{% for channel in auxiliary %}
#     {{ channel|comment }}
{% endfor %}
#
{% endif %}
# Gauges have the order above and the unit of the training recordings; loads have the order and units above. The time is in
# seconds on any clock. The history is empty at the first sample.
#
# After an update the status is in `state.status`.
{% for line in statuses %}
# {{ line }}
{% endfor %}
#
# To tare an unloaded sensor, pass the mean of its gauges over several samples to `state.tare`.
#
{% if ring %}
# The history stores at most one sample in {{ history_step_secs|plain }} s, at any sample rate.
{% endif %}
# Cost of an update: {{ products }} multiplications{{ search_cost }}.

import numpy as np

GAUGES = {{ n_gauges }}
{% if auxiliary %}
AUXILIARY = {{ n_auxiliary }}
{% endif %}
AXES = {{ n_axes }}
OK = 0
{% for name, bits in flags %}
{{ name }} = {{ bits }}
{% endfor %}
{% if look_backs %}
BOX = 64  # number of samples in a box, of which the search knows the smallest and largest point
{% endif %}
LEAP_SECS = {{ leap_secs|number }}  # step in time above which a time is implausible (s)
STRAYS = {{ strays }}  # number of successive implausible times after which the clock counts as reset
WRAPS_SECS = {{ wraps_secs|times }}  # wrap-around of 32-bit counters (s)
GAP_SECS = {{ gap_secs|plain }}
WINDOW_SECS = {{ window_secs|plain }}
HISTORY_STEP_SECS = {{ history_step_secs|plain }}
LIMITS = np.array({{ limits|numbers }})
{% if gauge_low %}
GAUGE_LOW, GAUGE_HIGH = np.array([{{ gauge_low|numbers }}, {{ gauge_high|numbers }}])  # values at which a gauge is clipped
{% endif %}
UNLOADED = np.array({{ unloaded|numbers }})  # tared gauges of the unloaded sensor

CENTRE = np.array({{ centre|numbers }})
CONVENTIONAL = np.array({{ conventional.matrix|rows }})
CONVENTIONAL_BASE = np.array({{ conventional.base|numbers }})
{% if look_backs %}
MEASURED_AXIS = np.array({{ measured|map(attribute=0)|indices }})
MEASURED_WEIGHT = np.array({{ measured|map(attribute=1)|numbers }})
F_TH_SQUARED = {{ look_backs|map(attribute=0)|numbers }}
T_TH_SECS = {{ look_backs|map(attribute=1)|numbers }}
{% endif %}
{% for block in blocks %}
{% for constant in block.source.constants %}
{{ constant.name|upper }} = np.array({{ constant.numbers|rows if constant.numbers[0] is sequence else constant.numbers|numbers }})
{% endfor %}
{% endfor %}
{% if linear %}
LINEAR = np.array({{ linear.matrix|rows }})
LINEAR_BASE = np.array({{ linear.base|numbers }})
{% endif %}
{% if learned %}
INPUT_FACTOR = np.array({{ learned.inputs|map(attribute=0)|numbers }})
INPUT_CONSTANT = np.array({{ learned.inputs|map(attribute=1)|numbers }})
{% endif %}
{% if network %}
LAYERS = [  # weights (one row for each input), biases
{% for layer in layers %}
    (np.array({{ layer.weights|weights }}).reshape({{ layer.inputs }}, {{ layer.biases|length }}),
     np.array({{ layer.biases|weights }})),
{% endfor %}
]
TARGET_SCALE = np.array({{ network.target_scale|numbers }})
TARGET_SHIFT = np.array({{ network.target_shift|numbers }})
{% endif %}
{% if kernel %}
LANDMARKS = np.array({{ kernel.landmarks|rows }})
KERNEL_WEIGHTS = np.array({{ kernel.weights|rows }})
KERNEL_OFFSET = np.array({{ kernel.offset|numbers }})
KERNEL_FACTOR = {{ kernel_factor|number }}
{% endif %}


class State:
    """State between samples."""

    def __init__(self):
        self.time = 0.0
        self.wrapped = 0.0
        self.since = 0.0
        self.status = OK
        self.strays = 0
        self.load = np.zeros(AXES)
        self.conventional = np.zeros(AXES)
        self.load_zero = np.zeros(AXES)
        self.conventional_zero = np.zeros(AXES)
        self.gauge_zero = np.zeros(GAUGES)
        self.started = False
        self.missing = 0.0
{% if fades %}
        self.unknown = 0.0
{% endif %}
{% if ring %}
        # The stored samples are contiguous. When the array is full, old samples are dropped or the array is doubled.
        self.kept = 0
        self.last_kept = 0.0
        self.newest_stays = True
        self.times = np.empty(1024)
        self.gauges = np.empty((1024, GAUGES))
{% endif %}
{% if look_backs %}
        self.points = np.empty((1024, len(MEASURED_AXIS)))
        self.low = np.empty((1024 // BOX, len(MEASURED_AXIS)))
        self.high = np.empty((1024 // BOX, len(MEASURED_AXIS)))
{% endif %}

    def tare(self, mean):
        """Tares: subtracts these gauges from now on, the mean of several samples of the unloaded sensor. Restarts the history."""
        mean = np.asarray(mean, dtype=float)
        if mean.shape != (GAUGES,) or not np.all(np.isfinite(mean)):
            raise ValueError(f"{GAUGES} finite numbers are needed")
        self.gauge_zero = mean - UNLOADED
        self.load_zero = self.conventional_zero = 0.0
        self._forget()

    def zero_last_load(self):
        """Subtracts the load of the last sample that was not rejected; to tare gauges, use `tare`. The history is kept."""
        self.load_zero = self.load
        self.conventional_zero = self.conventional

    def update(self, time, gauges{{ ", auxiliary" if auxiliary }}):
        """Processes the next sample; returns its load and its conventional load (from the present gauges alone), NaN if rejected."""
        gauges = np.asarray(gauges, dtype=float)
        if gauges.shape != (GAUGES,):
            raise ValueError(f"{gauges.shape} gauges are given where {GAUGES} are needed")
{% if auxiliary %}
        auxiliary = np.asarray(auxiliary, dtype=float)
        if auxiliary.shape != (AUXILIARY,):
            raise ValueError(f"{auxiliary.shape} auxiliary channels are given where {AUXILIARY} are needed")
{% endif %}
        time = float(time)
        self.status = self._judge(time, {{ "np.append(gauges, auxiliary)" if auxiliary else "gauges" }})
        if self.status >= REJECTED_TIME:
            return np.full(AXES, np.nan), np.full(AXES, np.nan)
        self.strays = 0
        if self.status == RESTARTED:
            self._forget()
        time += self.wrapped
        if not self.started or self.status != OK:
            self.since = time
        dt = time - self.time
        self.time = time
        self._take(time, dt, (gauges - self.gauge_zero) - CENTRE{{ ", auxiliary" if auxiliary }})
        self.started = True
        if time - self.since < WINDOW_SECS or self.missing > 1:
            self.status |= FILLING
        if np.any(np.abs(self.load) > LIMITS):
            self.status |= BEYOND
{% if auxiliary %}
        if np.any(auxiliary < AUXILIARY_LOW) or np.any(auxiliary > AUXILIARY_HIGH):
            self.status |= BEYOND
{% endif %}
{% if gauge_low %}
        if not np.all((GAUGE_LOW < gauges{{ " - self.gauge_zero" if limits_tared }}) & (gauges{{ " - self.gauge_zero" if limits_tared }} < GAUGE_HIGH)):
            self.status |= BEYOND
{% endif %}
        return self.load - self.load_zero, self.conventional - self.conventional_zero

    def _judge(self, time, gauges):
        """Returns the status of a sample."""
        if not (np.isfinite(time) and np.all(np.isfinite(gauges))):
            return REJECTED_VALUE
        if not self.started:
            return OK
        step = time + self.wrapped - self.time
        for wrap in WRAPS_SECS:
            if step < 0 <= step + wrap <= GAP_SECS:
                self.wrapped += wrap
                step += wrap
        if 0 <= step <= LEAP_SECS:
            return OK if step <= GAP_SECS else AFTER_GAP
        self.strays += 1
        if self.strays < STRAYS:
            return REJECTED_TIME
        self.wrapped = 0.0
        return RESTARTED

    def _forget(self):
        self.started = False
        self.strays = 0
{% if ring %}
        self.kept = 0
{% endif %}

    def _take(self, time, dt, present{{ ", auxiliary" if auxiliary }}):
        self.missing = 0.0
{% if fades %}
        self.unknown = 0.0
        if not self.started:
            self.share = 1.0
{% endif %}
        self.conventional = CONVENTIONAL_BASE + CONVENTIONAL @ present
        # Gauges minus centre, then for each history past gauges minus present gauges, then monomials.
        row = [present]
{% if ring %}
        if dt > {{ stored_keep_secs|plain }}:
            self.kept = 0
        self._keep(time, present)
{% endif %}
{% if look_backs %}
        for f_th_squared, t_th_secs in zip(F_TH_SQUARED, T_TH_SECS):
            row.append(self.gauges[self._past(time, f_th_squared, t_th_secs)] - present)
{% endif %}
{% for block in blocks %}
{% if "started" in block.source.python.update %}
        started = self.started and dt <= {{ block.keep_secs|plain }}
{% endif %}
{{ block.source.python.update|filled(block.sets) }}
{% endfor %}
        self.load = _answer(np.concatenate(row))
{% if fades %}
        self.share = min(1 / (1 + self.unknown**2), self.share + {{ most_rise }})
        self.load = self.conventional + self.share * (self.load - self.conventional)
{% endif %}
{% if ring %}

    def _keep(self, time, present):
        if self.kept > 0 and not self.newest_stays:
            self.kept -= 1
        self.newest_stays = self.kept == 0 or time - self.last_kept >= HISTORY_STEP_SECS
        if self.newest_stays:
            self.last_kept = time
        if self.kept == len(self.times):
            self._make_room(time)
        self.times[self.kept] = time
        self.gauges[self.kept] = present
{% if look_backs %}
        self.points[self.kept] = self.conventional[MEASURED_AXIS] * MEASURED_WEIGHT
{% endif %}
        self.kept += 1
{% if look_backs %}
        if self.kept % BOX == 0:
            box = self.points[self.kept - BOX : self.kept]
            self.low[self.kept // BOX - 1], self.high[self.kept // BOX - 1] = box.min(axis=0), box.max(axis=0)
{% endif %}

    def _make_room(self, time):
        # One sample older than the window is kept, because a lag may fall between two samples. Whole boxes are dropped.
        old = max(np.searchsorted(self.times, time - WINDOW_SECS) - 2, 0){{ " // BOX * BOX" if look_backs }}
        size = len(self.times) * (2 if old < self.kept // 2 else 1)
        self.kept -= old

        def moved(values, each=1):
            room = np.empty((size // each,) + values.shape[1:])
            room[: self.kept // each] = values[old // each :]
            return room

        self.times = moved(self.times)
        self.gauges = moved(self.gauges)
{% if look_backs %}
        self.points = moved(self.points)
        self.low, self.high = moved(self.low, BOX), moved(self.high, BOX)
{% endif %}
{% endif %}
{% if look_backs %}

    def _past(self, time, f_th_squared, t_th_secs):
        """Look-back: returns the first sample backwards that differs by F_th and is no older than t_th, or else the newest."""
        n_boxes = self.kept // BOX
        point = self.points[self.kept - 1]
        # Searches the samples after the last whole box, then boxes whose farthest corner differs by F_th, from the newest
        # backwards, in groups that double.
        corner = np.maximum(point - self.low[:n_boxes], self.high[:n_boxes] - point)
        boxes = np.flatnonzero(np.square(corner).sum(axis=1) >= f_th_squared)[::-1]
        samples = np.arange(self.kept - 1, n_boxes * BOX - 1, -1)
        size = 1
        while True:
            found = np.flatnonzero(np.square(self.points[samples] - point).sum(axis=1) >= f_th_squared)
            if len(found):
                past = samples[found[0]]
                return past if time - self.times[past] <= t_th_secs else self.kept - 1
            if len(boxes) == 0 or time - self.times[boxes[0] * BOX + BOX - 1] > t_th_secs:
                return self.kept - 1
            group, boxes = boxes[:size], boxes[size:]
            samples = (group[:, None] * BOX + np.arange(BOX)[::-1]).ravel()
            size *= 2
{% endif %}
{% for block in blocks if block.source.python.functions %}

{{ block.source.python.functions|filled(block.sets) }}
{% endfor %}


def _answer(row):
{% if linear %}
    load = LINEAR_BASE + LINEAR @ row
{% endif %}
{% if not linear %}
    load = np.zeros(AXES)
{% endif %}
{% if learned %}
    row = row * INPUT_FACTOR + INPUT_CONSTANT
{% endif %}
{% if network %}
    for at, (weights, biases) in enumerate(LAYERS):
        row = row @ weights + biases
        if at + 1 < len(LAYERS):
            row = np.maximum(row, 0.0)
    load = load + TARGET_SHIFT + TARGET_SCALE * row
{% endif %}
{% if kernel %}
    similarities = np.exp(KERNEL_FACTOR * np.square(LANDMARKS - row).sum(axis=1))
    load = load + KERNEL_OFFSET + KERNEL_WEIGHTS @ similarities
{% endif %}
    return load


def apply(times, gauges{{ ", auxiliary" if auxiliary }}):
    """Returns the loads and conventional loads of a whole recording, whose history starts with its first sample."""
    state = State()
    loads = [state.update(time, {{ "row, others" if auxiliary else "row" }}) for time, row{{ ", others" if auxiliary }} in zip(times, gauges{{ ", auxiliary" if auxiliary }})]
    return np.array([load for load, _ in loads]), np.array([conventional for _, conventional in loads])

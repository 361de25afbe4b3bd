function [load, conventional, status, state] = {{ prefix }}(state, time, gauges{{ ", auxiliary" if auxiliary }})
%{{ prefix|upper }} Calibration of a force/torque sensor. Computes the load from the gauges, one sample at a time.
%
{% for fact in facts %}
% {{ fact|comment }}
{% endfor %}
%
% This file must be called {{ prefix }}.m.
%
% Three calls create a state, process the next sample, and tare by the mean of the gauges over samples of the unloaded sensor:
%
%     state = {{ prefix }}();
%     [load, conventional, status, state] = {{ prefix }}(state, time, gauges{{ ", auxiliary" if auxiliary }});
%     state = {{ prefix }}(state, mean);
%
{% if auxiliary %}
% Auxiliary channels, in this order and unit. A value that leaves its range by more than a tenth of the range sets
% the flag 8:
{% for channel in auxiliary %}
%     {{ channel|comment }}
{% endfor %}
%
{% endif %}
% Gauges have the order above and the unit of the training recordings; loads have the order and units above, as columns. The
% time is in seconds on any clock. The history is empty at the first sample. In a MATLAB Function
% block of Simulink the state is persistent:
%
%     function [load, status] = block(time, gauges{{ ", auxiliary" if auxiliary }})
%     persistent state
%     if isempty(state)
%         state = {{ prefix }}();
%     end
%     [load, ~, status, state] = {{ prefix }}(state, time, gauges{{ ", auxiliary" if auxiliary }});
%
{% for line in statuses %}
% {{ line }}
{% endfor %}
% Test one flag by bitand, e.g. bitand(status, 8) for BEYOND.
{% if ring %}
%
% The history stores at most one sample in {{ history_step_secs|plain }} s, at any sample rate.
{% endif %}

%#codegen
persistent c
if isempty(c)
    c = {{ prefix }}_constants();
end
conventional = nan({{ n_axes }}, 1);
status = 0;
if nargin == 0
    state = {{ prefix }}_new();
    load = state;
    return
elseif nargin == 2
    mean_gauges = double(time(:));
    if numel(mean_gauges) ~= {{ n_gauges }} || ~all(isfinite(mean_gauges))
        error('{{ n_gauges }} finite numbers are needed');
    end
    state.gauge_zero = mean_gauges - c.unloaded;
    state = {{ prefix }}_forget(state);
    load = state;
    return
end
if numel(gauges) ~= {{ n_gauges }}
    error('{{ n_gauges }} gauges are needed');
end
gauges = double(gauges(:));
{% if auxiliary %}
if numel(auxiliary) ~= {{ n_auxiliary }}
    error('{{ n_auxiliary }} auxiliary channels are needed');
end
auxiliary = double(auxiliary(:));
{% endif %}
time = double(time);
load = nan({{ n_axes }}, 1);
[status, state] = {{ prefix }}_judge(c, state, time, {{ "[gauges; auxiliary]" if auxiliary else "gauges" }});
if status >= 16
    return
end
state.strays = 0;
if status == 4
    state = {{ prefix }}_forget(state);
end
time = time + state.wrapped;
if ~state.started || status ~= 0
    state.since = time;
end
{% if uses_dt %}
dt = 0;
if state.started
    dt = time - state.time;
end
{% endif %}
state.time = time;
present = (gauges - state.gauge_zero) - c.centre;
conventional = c.conventional_base + c.conventional * present;
{% if ring %}
if dt > {{ stored_keep_secs|plain }}
    state.kept = 0;
end
state = {{ prefix }}_keep(state, present{{ ", conventional(c.measured_axis) .* c.measured_weight" if look_backs else "" }});
{% endif %}
% Gauges minus centre, then for each history past gauges minus present gauges, then monomials.
row = zeros({{ n_columns }}, 1);
row(1:{{ n_gauges }}) = present;
state.missing = 0;
{% if fades %}
state.unknown = 0;
if ~state.started
    state.share = 1;
end
{% endif %}
{% if n_columns > n_gauges %}
next = {{ n_gauges }};
{% endif %}
{% if look_backs %}
for at = 1:{{ look_backs|length }}
    row(next + (1:{{ n_gauges }})) = state.gauges(:, {{ prefix }}_past(state, c.f_th_squared(at), c.t_th_secs(at))) - present;
    next = next + {{ n_gauges }};
end
{% endif %}
{% for block in blocks %}
{% if "started" in block.source.matlab.update %}
started = state.started && dt <= {{ block.keep_secs|plain }};
{% endif %}
{% if "is_gap" in block.source.matlab.update %}
is_gap = dt > {{ gap_secs|plain }};
{% endif %}
{{ block.source.matlab.update|filled(block.sets) }}
{% endfor %}
state.started = true;
load = {{ prefix }}_answer(c, row);
{% if fades %}
state.share = min(1 / (1 + state.unknown ^ 2), state.share + {{ most_rise }});
load = conventional + state.share * (load - conventional);
{% endif %}
if time - state.since < {{ window_secs|plain }} || state.missing > 1
    status = status + 1;
end
is_beyond = any(abs(load) > c.limits);
{% if auxiliary %}
is_beyond = is_beyond || any(auxiliary < c.auxiliary_low) || any(auxiliary > c.auxiliary_high);
{% endif %}
{% if gauge_low %}
is_beyond = is_beyond || any(gauges{{ " - state.gauge_zero" if limits_tared }} <= c.gauge_low) || any(gauges{{ " - state.gauge_zero" if limits_tared }} >= c.gauge_high); % clipped
{% endif %}
if is_beyond
    status = status + 8;
end
end

function state = {{ prefix }}_new()
% State between samples.
state.started = false;
state.missing = 0;
{% if fades %}
state.unknown = 0;
{% endif %}
state.strays = 0;
state.time = 0;
state.wrapped = 0;
state.since = 0;
state.gauge_zero = zeros({{ n_gauges }}, 1);
{% if ring %}
% The stored samples form a ring buffer.
state.kept = 0;
state.newest = 1;
state.newest_stays = true;
state.last_kept = 0;
state.times = zeros(1, {{ ring_samples }});
state.gauges = zeros({{ n_gauges }}, {{ ring_samples }});
{% endif %}
{% if look_backs %}
state.points = zeros({{ measured|length }}, {{ ring_samples }});
state.low = zeros({{ measured|length }}, {{ ring_samples // 64 }}); % smallest and largest points of 64 samples
state.high = zeros({{ measured|length }}, {{ ring_samples // 64 }});
{% endif %}
{% for block in blocks %}
{% for memory in block.source.memory if "state." ~ memory.name ~ "(" in block.source.matlab.update %}
state.{{ memory.name }} = zeros({{ n_gauges if memory.of_gauges else 1 }}, {{ memory.sets }});
{% endfor %}
{% endfor %}
end

function state = {{ prefix }}_forget(state)
state.started = false;
state.strays = 0;
{% if ring %}
state.kept = 0;
{% endif %}
end

function [status, state] = {{ prefix }}_judge(c, state, time, gauges)
% Returns the status of a sample.
status = 0;
if ~(isfinite(time) && all(isfinite(gauges)))
    status = 32;
    return
end
if ~state.started
    return
end
step = time + state.wrapped - state.time;
for at = 1:numel(c.wraps_secs)
    if step < 0 && step + c.wraps_secs(at) >= 0 && step + c.wraps_secs(at) <= {{ gap_secs|plain }}
        state.wrapped = state.wrapped + c.wraps_secs(at);
        step = step + c.wraps_secs(at);
    end
end
if step < 0 || step > {{ leap_secs|plain }}
    state.strays = state.strays + 1;
    status = 16;
    if state.strays >= {{ strays }}
        status = 4;
        state.wrapped = 0;
    end
elseif step > {{ gap_secs|plain }}
    status = 2;
end
end
{% if ring %}

function state = {{ prefix }}_keep(state, present{{ ", point" if look_backs else "" }})
% Stores the sample, in place of the previous sample if that one came too soon.
if state.kept == 0
    state.newest = 1;
    state.kept = 1;
elseif state.newest_stays
    state.newest = 1 + mod(state.newest, {{ ring_samples }});
    if mod(state.newest, 64) == 1
        state.kept = min(state.kept, {{ ring_samples - 64 }}); % the oldest box is overwritten
    end
    state.kept = state.kept + 1;
end
state.newest_stays = state.kept == 1 || state.time - state.last_kept >= {{ history_step_secs|plain }};
if state.newest_stays
    state.last_kept = state.time;
end
state.times(state.newest) = state.time;
state.gauges(:, state.newest) = present;
{% if look_backs %}
state.points(:, state.newest) = point;
box = ceil(state.newest / 64);
if mod(state.newest, 64) == 1
    state.low(:, box) = point;
    state.high(:, box) = point;
elseif state.newest_stays
    state.low(:, box) = min(state.low(:, box), point);
    state.high(:, box) = max(state.high(:, box), point);
end
{% endif %}
end

function slot = {{ prefix }}_slot(state, back)
% Returns the index of the sample that is this number of samples older than the newest.
slot = 1 + mod(state.newest - 1 - back, {{ ring_samples }});
end
{% endif %}
{% if look_backs %}

function past = {{ prefix }}_past(state, f_th_squared, t_th_secs)
% Look-back: returns, from the newest sample backwards, the first sample that differs by F_th and is no older than t_th, or else
% the newest sample.
past = state.newest;
point = state.points(:, state.newest);
corner = zeros(1, {{ ring_samples // 64 }});
for axis = 1:{{ measured|length }}
    corner = corner + max(point(axis) - state.low(axis, :), state.high(axis, :) - point(axis)) .^ 2;
end
% Searches boxes whose farthest corner differs by F_th, from the newest backwards, in groups that double.
order = 1 + mod(ceil(state.newest / 64) - (1:{{ ring_samples // 64 }}), {{ ring_samples // 64 }});
boxes = order(corner(order) >= f_th_squared);
first = 1;
size_of_group = 1;
while first <= numel(boxes)
    group = boxes(first:min(first + size_of_group - 1, numel(boxes)));
    slots = kron(64 * group, ones(1, 64)) - repmat(0:63, 1, numel(group));
    back = mod(state.newest - slots, {{ ring_samples }});
    squares = zeros(1, numel(slots));
    for axis = 1:{{ measured|length }}
        squares = squares + (state.points(axis, slots) - point(axis)) .^ 2;
    end
    far = find(back < state.kept & squares >= f_th_squared, 1);
    if ~isempty(far)
        if state.time - state.times(slots(far)) <= t_th_secs
            past = slots(far);
        end
        return
    end
    if back(end) >= state.kept || state.time - state.times(slots(end)) > t_th_secs
        return
    end
    first = first + size_of_group;
    size_of_group = 2 * size_of_group;
end
end
{% endif %}
{% for block in blocks if block.source.matlab.functions %}

{{ block.source.matlab.functions|filled(block.sets) }}
{% endfor %}

function load = {{ prefix }}_answer(c, row)
{% if linear %}
load = c.linear_base + c.linear * row;
{% endif %}
{% if not linear %}
load = zeros({{ n_axes }}, 1);
{% endif %}
{% if learned %}
row = row .* c.input_factor + c.input_constant;
{% endif %}
{% if network %}
{% for layer in layers %}
{% set sums = "c.weights_" ~ loop.index0 ~ " * " ~ ("row" if loop.first else "values_" ~ (loop.index0 - 1)) ~ " + c.biases_" ~ loop.index0 %}
values_{{ loop.index0 }} = {{ sums if loop.last else "max(" ~ sums ~ ", 0)" }};
{% endfor %}
load = load + c.target_shift + c.target_scale .* values_{{ layers|length - 1 }};
{% endif %}
{% if kernel %}
squares = zeros({{ kernel.landmarks|length }}, 1);
for column = 1:{{ n_columns }}
    squares = squares + (c.landmarks(:, column) - row(column)) .^ 2;
end
load = load + c.kernel_offset + c.kernel_weights * exp({{ kernel_factor|plain }} * squares);
{% endif %}
end

function c = {{ prefix }}_constants()
c.wraps_secs = {{ wraps_secs|times }}; % wrap-around of 32-bit counters
c.limits = {{ limits|numbers }}';
{% if gauge_low %}
c.gauge_low = {{ gauge_low|numbers }}';
c.gauge_high = {{ gauge_high|numbers }}';
{% endif %}
c.unloaded = {{ unloaded|numbers }}'; % tared gauges of the unloaded sensor
c.centre = {{ centre|numbers }}';
c.conventional = {{ conventional.matrix|rows }};
c.conventional_base = {{ conventional.base|numbers }}';
{% if look_backs %}
c.measured_axis = 1 + {{ measured|map(attribute=0)|indices }}';
c.measured_weight = {{ measured|map(attribute=1)|numbers }}';
c.f_th_squared = {{ look_backs|map(attribute=0)|numbers }}';
c.t_th_secs = {{ look_backs|map(attribute=1)|numbers }}';
{% endif %}
{% for block in blocks %}
{% for constant in block.source.constants %}
c.{{ constant.name }} = {{ constant.numbers|rows if constant.numbers[0] is sequence else constant.numbers|numbers ~ "'" }};
{% endfor %}
{% endfor %}
{% if linear %}
c.linear = {{ linear.matrix|rows }};
c.linear_base = {{ linear.base|numbers }}';
{% endif %}
{% if learned %}
c.input_factor = {{ learned.inputs|map(attribute=0)|numbers }}';
c.input_constant = {{ learned.inputs|map(attribute=1)|numbers }}';
{% endif %}
{% if network %}
{% for layer in layers %}
c.weights_{{ loop.index0 }} = reshape({{ layer.weights|weights }}, {{ layer.biases|length }}, {{ layer.inputs }});
c.biases_{{ loop.index0 }} = {{ layer.biases|weights }}';
{% endfor %}
c.target_scale = {{ network.target_scale|numbers }}';
c.target_shift = {{ network.target_shift|numbers }}';
{% endif %}
{% if kernel %}
c.landmarks = {{ kernel.landmarks|rows }};
c.kernel_weights = {{ kernel.weights|rows }};
c.kernel_offset = {{ kernel.offset|numbers }}';
{% endif %}
end

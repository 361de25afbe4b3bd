% The self-test: runs the calibration on the samples of ../expected.csv and compares the loads. Ends with an error if they differ.
here = fileparts(mfilename('fullpath'));
addpath(here);
full_scale = [{{ full_scale|join(', ') }}]';
allowed = {{ allowed_double }};
file = fopen(fullfile(here, '..', 'expected.csv'));
fgetl(file); % names
state = {{ m_name }}();
worst = 0;
taken = 0;
compared = 0;
bad = 0;
line = fgetl(file);
while ischar(line)
    numbers = sscanf(strrep(line, ',', ' '), '%f');
    line = fgetl(file);
    expected = numbers({{ n_gauges + n_auxiliary }} + 2:end);
    [load_now, conventional, status, state] = {{ m_name }}(state, numbers(1), numbers(2:{{ n_gauges }} + 1){{ ', numbers(' ~ (n_gauges + 2) ~ ':' ~ (n_gauges + n_auxiliary + 1) ~ ')' if auxiliary }});
    taken = taken + 1;
    if expected(end) > 0
        continue
    end
    compared = compared + 1;
    actual = [load_now; conventional];
    by = abs(actual - expected(1:{{ 2 * n_axes }})) ./ [full_scale; full_scale];
    by(isnan(actual) & isnan(expected(1:{{ 2 * n_axes }}))) = 0;
    by(isnan(by)) = Inf;
    worst = max([worst; by]);
    if any(by > allowed) || status ~= expected(end - 1)
        bad = bad + 1;
        if bad == 1
            fprintf('line %d: error %g of full scale, status %d instead of %d\n', taken + 1, max(by), status, expected(end - 1));
        end
    end
end
fclose(file);
verdict = 'PASS';
if bad > 0
    verdict = 'FAIL';
end
fprintf('%s: %d of %d samples compared, %d differ; largest difference %g of full scale, %g allowed\n', ...
    verdict, compared, taken, bad, worst, allowed);
if bad > 0
    error('the calibration gives other loads here than in LoopScope');
end

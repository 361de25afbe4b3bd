/*
 * The self-test: runs every sample of expected.csv through the calibration and compares its load, conventional load and status
 * with those of LoopScope's own estimator. It prints PASS or FAIL with the largest difference, and ends with 0 or 1; with 2 if
 * the file cannot be read. It is also an example of use.
 *
 *     cc -Isrc main.c -lm -o selftest && ./selftest expected.csv
 *
 * With -DLOOPSCOPE_REAL=float it tests single precision. On a machine without files, replace next_line, which
 * reads the samples.
 */
#include "{{ name }}.h"

#include <stdio.h>
#include <stdlib.h>

#define INPUTS ({{ NAME }}_GAUGES + {{ n_auxiliary }})
#define COLUMNS (3 + INPUTS + 2 * {{ NAME }}_AXES)

static const double full_scale[{{ NAME }}_AXES] = {{ '{' }}{{ full_scale|join(', ') }}{{ '}' }};
static {{ name }}_state state;

/* Reads numbers separated by commas. Returns their number, 0 at the end of the file. */
static int next_line(FILE *file, double numbers[COLUMNS])
{
    static char line[{{ line_bytes }}];
    char *at = line, *end;
    int n = 0;
    if (fgets(line, (int)sizeof line, file) == NULL)
        return 0;
    while (n < COLUMNS) {
        numbers[n] = strtod(at, &end);
        if (end == at)
            break;
        n += 1;
        at = *end == ',' ? end + 1 : end;
    }
    return n;
}

/* Returns the difference of two loads as a share of full scale; two NaN are equal. */
static double difference(double actual, double expected, double scale)
{
    int is_none = !(actual <= 0 || actual >= 0), is_none_expected = !(expected <= 0 || expected >= 0);
    double by = (actual - expected) / scale;
    if (is_none || is_none_expected)
        return is_none && is_none_expected ? 0 : 1e30;
    return by < 0 ? -by : by;
}

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "expected.csv";
    const double allowed = LOOPSCOPE_FLOAT ? {{ allowed_float }} : {{ allowed_double }};
    double numbers[COLUMNS], worst = 0;
    long taken = 0, compared = 0, bad = 0, first_bad = 0;
    int n, i;
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        fprintf(stderr, "cannot read %s\n", path);
        return 2;
    }
    {{ name }}_init(&state);
    next_line(file, numbers); /* names */
    while ((n = next_line(file, numbers)) == COLUMNS) {
        const double *expected = numbers + 1 + INPUTS;
        {{ name }}_real gauges[INPUTS], load[{{ NAME }}_AXES], conventional[{{ NAME }}_AXES];
        {{ name }}_status status;
        double off = 0;
        for (i = 0; i < INPUTS; i++)
            gauges[i] = ({{ name }}_real)numbers[1 + i];
        status = {{ name }}_update(&{{ NAME }}_CALIBRATION, &state, numbers[0], gauges,{{ ' gauges + ' ~ NAME ~ '_GAUGES,' if auxiliary }} load, conventional);
        taken += 1;
        /* At the edge of a threshold, rounding decides which past sample is found. */
        if (expected[2 * {{ NAME }}_AXES + 1] > 0)
            continue;
        compared += 1;
        for (i = 0; i < {{ NAME }}_AXES; i++) {
            double by = difference((double)load[i], expected[i], full_scale[i]);
            double by_conventional = difference((double)conventional[i], expected[{{ NAME }}_AXES + i], full_scale[i]);
            off = by > off ? by : off;
            off = by_conventional > off ? by_conventional : off;
        }
        worst = off > worst ? off : worst;
        if (off > allowed || (int)status != (int)expected[2 * {{ NAME }}_AXES]) {
            bad += 1;
            if (bad == 1) {
                first_bad = taken + 1;
                printf("line %ld: error %g of full scale, status %d instead of %d\n", first_bad, off, (int)status,
                       (int)expected[2 * {{ NAME }}_AXES]);
            }
        }
    }
    fclose(file);
    if (n != 0 || taken != {{ n_rows }}) {
        fprintf(stderr, "%s does not belong to this calibration\n", path);
        return 2;
    }
    printf("%s: %ld of %ld samples compared, %ld differ; largest difference %g of full scale, %g allowed\n",
           bad == 0 ? "PASS" : "FAIL", compared, taken, bad, worst, allowed);
    return bad == 0 ? 0 : 1;
}

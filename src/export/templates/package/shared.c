/*
 * The calibration as a shared library with a handle, for programs that load functions by name: LabVIEW, C#, Python's ctypes, PLCs.
 *
 *     {{ name }}_sensor *{{ name }}_sensor_create(void);                          NULL if memory is short
 *     int {{ name }}_sensor_update(sensor, seconds, gauges, auxiliary, load, conventional);   the status, a sum of flags; -1 without a sensor
 *     int {{ name }}_sensor_tare(sensor, mean);                           0; -1 if a number is not finite
 *     void {{ name }}_sensor_reset(sensor);                               clears history and tare, as after create
 *     void {{ name }}_sensor_destroy(sensor);
 *
 * Numbers are double: {{ n_gauges }} gauges ({{ gauges }}), {{ n_auxiliary }} auxiliary channels (NULL if there are none), {{ n_axes }} loads ({{ axes }}).
 * `conventional` may be NULL. Flags of the status: {{ flags }}. One sensor belongs to one thread at a time.
 */
#include "{{ name }}.h"

#include <stdlib.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

typedef struct {
    {{ name }}_state state;
} {{ name }}_sensor;

EXPORTED {{ name }}_sensor *{{ name }}_sensor_create(void);
EXPORTED int {{ name }}_sensor_update({{ name }}_sensor *sensor, double seconds, const double *gauges, const double *auxiliary, double *load,
                                      double *conventional);
EXPORTED int {{ name }}_sensor_tare({{ name }}_sensor *sensor, const double *mean);
EXPORTED void {{ name }}_sensor_reset({{ name }}_sensor *sensor);
EXPORTED void {{ name }}_sensor_destroy({{ name }}_sensor *sensor);

{{ name }}_sensor *{{ name }}_sensor_create(void)
{
    {{ name }}_sensor *sensor = ({{ name }}_sensor *)malloc(sizeof *sensor);
    {{ name }}_sensor_reset(sensor);
    return sensor;
}

int {{ name }}_sensor_update({{ name }}_sensor *sensor, double seconds, const double *gauges, const double *auxiliary, double *load,
                             double *conventional)
{
    {{ name }}_real own[{{ NAME }}_GAUGES + {{ n_auxiliary }}], loads[{{ NAME }}_AXES], of_present[{{ NAME }}_AXES];
    int status, i;
    if (sensor == NULL || gauges == NULL || load == NULL{{ " || auxiliary == NULL" if n_auxiliary }})
        return -1;
{% if not n_auxiliary %}
    (void)auxiliary;
{% endif %}
    for (i = 0; i < {{ NAME }}_GAUGES; i++)
        own[i] = ({{ name }}_real)gauges[i];
{% if n_auxiliary %}
    for (i = 0; i < {{ n_auxiliary }}; i++)
        own[{{ NAME }}_GAUGES + i] = ({{ name }}_real)auxiliary[i];
{% endif %}
    status = (int){{ name }}_update(&{{ NAME }}_CALIBRATION, &sensor->state, seconds, own,{{ ' own + ' ~ NAME ~ '_GAUGES,' if n_auxiliary }} loads, of_present);
    for (i = 0; i < {{ NAME }}_AXES; i++) {
        load[i] = (double)loads[i];
        if (conventional != NULL)
            conventional[i] = (double)of_present[i];
    }
    return status;
}

int {{ name }}_sensor_tare({{ name }}_sensor *sensor, const double *mean)
{
    {{ name }}_real own[{{ NAME }}_GAUGES];
    int i;
    if (sensor == NULL || mean == NULL)
        return -1;
    for (i = 0; i < {{ NAME }}_GAUGES; i++) {
        own[i] = ({{ name }}_real)mean[i];
        if (!{{ name }}_is_finite(own[i]))
            return -1;
    }
    {{ name }}_tare(&{{ NAME }}_CALIBRATION, &sensor->state, own);
    return 0;
}

void {{ name }}_sensor_reset({{ name }}_sensor *sensor)
{
    if (sensor != NULL)
        {{ name }}_init(&sensor->state);
}

void {{ name }}_sensor_destroy({{ name }}_sensor *sensor)
{
    free(sensor);
}

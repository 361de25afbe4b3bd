/* Reads the gauges and prints the load, in single precision. */
#define LOOPSCOPE_REAL float
#include <{{ name }}.h>

static {{ name }}_state state;

/*
 * Read your amplifier here: the gauges in this order, in the unit of the training recordings:
 * {{ gauges }}
 */
static void read_gauges(float *gauges)
{
    for (int g = 0; g < {{ NAME }}_GAUGES; g++)
        gauges[g] = (float)analogRead(A0 + g);
}

{% if auxiliary %}/* Read the auxiliary channels here: {{ auxiliary }} */
static void read_auxiliary(float *auxiliary)
{
    for (int at = 0; at < {{ NAME }}_AUXILIARY; at++)
        auxiliary[at] = (float)analogRead(A0 + {{ NAME }}_GAUGES + at);
}

{% endif %}void setup()
{
    Serial.begin(115200);
    {{ name }}_init(&state);
}

void loop()
{
    float gauges[{{ NAME }}_GAUGES], load[{{ NAME }}_AXES];
    read_gauges(gauges);
{% if auxiliary %}    float auxiliary[{{ NAME }}_AUXILIARY];
    read_auxiliary(auxiliary);
{% endif %}    /* micros() wraps after 71 minutes, which update_ticks takes into account. */
    {{ name }}_status status = {{ name }}_update_ticks(&{{ NAME }}_CALIBRATION, &state, micros(), gauges,{{ ' auxiliary,' if auxiliary }} load, NULL);
    if ({{ NAME }}_IS_REJECTED(status))
        return;
    for (int axis = 0; axis < {{ NAME }}_AXES; axis++) {
        Serial.print(load[axis], 4);
        Serial.print(axis + 1 < {{ NAME }}_AXES ? '\t' : '\n');
    }
}

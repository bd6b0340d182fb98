/* The sensor plugin `smart_actuator.readings`: the outputs of a servo's board and motor. */
#ifndef SENSOR_H
#define SENSOR_H

void sensor_register(void);

#endif

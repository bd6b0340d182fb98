"""The C library through ctypes: the native board that the plugin must equal."""

import ctypes
import os

LIBRARY = ctypes.CDLL(os.environ["ACTUATOR_LIBRARY"])
LIBRARY.actuator_size.restype = ctypes.c_size_t
SETTINGS_BYTES, WHY_BYTES = 1024, 192


class Actuator:
    """An actuator of the C library, stepped by ticks of 50 us."""

    def __init__(self, plant, **parameters):
        settings = (ctypes.c_uint64 * (SETTINGS_BYTES // 8))()
        why = ctypes.create_string_buffer(WHY_BYTES)
        size = ctypes.c_size_t(SETTINGS_BYTES)
        code = LIBRARY.actuator_settings_init(settings, size, b"board", plant.encode(), why)
        assert code == 0, why.value
        for name, value in parameters.items():
            code = LIBRARY.actuator_settings_set(
                settings, name.encode(), ctypes.c_double(value), why
            )
            assert code == 0, why.value
        size = LIBRARY.actuator_size(settings)
        self._memory = (ctypes.c_uint64 * -(-size // 8))()
        assert (
            LIBRARY.actuator_start(self._memory, ctypes.c_size_t(size), settings, why) == 0
        ), why.value

    def advance(self, command_deg, ticks):
        """Advances, and returns tick, command, angle, rate, duty, measured angle and so on."""
        reading = (ctypes.c_double * 9)()
        command, ticks = ctypes.c_double(command_deg), ctypes.c_uint64(ticks)
        assert LIBRARY.actuator_advance(self._memory, command, ticks) == 0
        assert LIBRARY.actuator_read(self._memory, reading) == 0
        return reading

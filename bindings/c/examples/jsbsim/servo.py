"""The C library of the smart actuator through ctypes, and a JSBSim aircraft with an external servo."""
import ctypes
import math
import pathlib
import shutil
import xml.etree.ElementTree as xml

import jsbsim

ABI_VERSION = 2


class _Settings(ctypes.Structure):
    _fields_ = [("opaque", ctypes.c_uint64 * 128)]


class _Why(ctypes.Structure):
    _fields_ = [("text", ctypes.c_char * 192)]


class Reading(ctypes.Structure):
    """struct actuator_reading: the outputs of an actuator."""

    _fields_ = [("tick", ctypes.c_uint64)] + [
        (name, ctypes.c_double)
        for name in ("command_deg", "angle_deg", "rate_deg_s", "duty_pct", "angle_meas_deg", "rate_meas_deg_s",
                     "current_a", "back_emf_v")
    ]


class Servo:
    """An actuator of the C library."""

    def __init__(self, library, model, plant=None, **parameters):
        self._c = ctypes.CDLL(str(library))
        if self._c.actuator_abi_version() != ABI_VERSION:
            raise RuntimeError("the library is of another version")
        settings, self._why = _Settings(), _Why()
        s, why = ctypes.byref(settings), ctypes.byref(self._why)
        size = ctypes.c_size_t(ctypes.sizeof(settings))
        plant = None if plant is None else plant.encode()
        self._check(self._c.actuator_settings_init(s, size, model.encode(), plant, why))
        for name, value in parameters.items():
            self._check(self._c.actuator_settings_set(s, name.encode(), ctypes.c_double(value), why))
        # The memory grows with the delay.
        self._c.actuator_size.restype = ctypes.c_size_t
        size = self._c.actuator_size(s)
        self._actuator = (ctypes.c_uint64 * (size // 8))()
        self._check(self._c.actuator_start(ctypes.byref(self._actuator), ctypes.c_size_t(size), s, why))

    def _check(self, code):
        if code:
            raise ValueError(self._why.text.decode() or f"error {code}")

    def advance_to(self, command_deg, time_s):
        """Advances to a time after the start, s, with a constant command, deg; returns the angle, deg."""
        self._why.text = b""
        self._check(self._c.actuator_advance_to(
            ctypes.byref(self._actuator), ctypes.c_double(command_deg), ctypes.c_double(time_s)))
        return self.reading().angle_deg

    def reading(self):
        """The present outputs."""
        now = Reading()
        self._check(self._c.actuator_read(ctypes.byref(self._actuator), ctypes.byref(now)))
        return now


def aircraft(folder):
    """Writes c172x with a servo in its elevator into the folder, and returns the name of the aircraft.

    Its own elevator actuator makes room for the property servo/elevator-deg; the system black_box_1 comes aboard.
    """
    root, folder, name = pathlib.Path(jsbsim.get_default_root_dir()), pathlib.Path(folder), "c172x-servo"
    place = folder / "aircraft" / name
    shutil.copytree(root / "aircraft" / "c172x", place)
    shutil.copytree(root / "engine", folder / "engine")
    shutil.copytree(root / "systems", folder / "systems")
    shutil.copy(pathlib.Path(__file__).with_name("black_box_1.xml"), folder / "systems")
    tree = xml.parse(place / "c172x.xml")
    channel = tree.find(".//flight_control/channel[@name='Pitch']")
    channel.remove(channel.find("actuator[@name='fcs/elevator-actuator']"))
    channel.append(xml.fromstring(
        f"<pure_gain name='fcs/elevator-servo'><input>servo/elevator-deg</input>"
        f"<gain>{math.radians(1)}</gain><output>fcs/elevator-pos-rad</output></pure_gain>"))
    control = tree.find("flight_control")
    control.insert(0, xml.fromstring("<property value='0'>servo/elevator-deg</property>"))
    parts = list(tree.getroot())
    tree.getroot().insert(parts.index(control), xml.fromstring("<system file='black_box_1'/>"))
    tree.write(place / f"{name}.xml")
    return name


def simulator(folder, name, frame_s):
    """JSBSim with that aircraft and this frame time, s, without log output."""
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(str(folder))
    fdm.set_debug_level(0)
    fdm.set_dt(frame_s)
    if not fdm.load_model(name):
        raise RuntimeError(f"JSBSim does not load {name}")
    return fdm

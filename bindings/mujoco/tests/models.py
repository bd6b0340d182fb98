"""Models of MuJoCo with servos."""

import mujoco

#: Elements of the sensor.
COMMAND, ANGLE, RATE, DUTY, MEASURED_ANGLE, MEASURED_RATE, CURRENT, BACK_EMF = range(8)


def extension(count=1, **attributes):
    """The instances of the plugin: servos s0, s1 and so on, and their sensors r0, r1."""
    attributes = {"parameters": "delay_s 0", **attributes}
    keys = "".join(f'<config key="{k}" value="{v}"/>' for k, v in attributes.items())
    servos = "".join(f'<instance name="s{i}">{keys}</instance>' for i in range(count))
    sensors = "".join(
        f'<instance name="r{i}"><config key="servo" value="s{i}"/></instance>' for i in range(count)
    )
    return (
        f'<extension><plugin plugin="smart_actuator.servo">{servos}</plugin>'
        f'<plugin plugin="smart_actuator.readings">{sensors}</plugin></extension>'
    )


def actuators(count=1, more=""):
    """The actuators at the joints j0, j1 and so on, and the sensors."""
    act = "".join(
        f'<plugin joint="j{i}" plugin="smart_actuator.servo" instance="s{i}" {more}/>'
        for i in range(count)
    )
    sense = "".join(
        f'<plugin plugin="smart_actuator.readings" instance="r{i}"/>' for i in range(count)
    )
    return f"<actuator>{act}</actuator><sensor>{sense}</sensor>"


def link(timestep=0.001, inertia=0.001, joint="", option="", actuator="", **attributes):
    """A single link that turns about its centre of mass."""
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco><option timestep="{timestep}" {option}/>{extension(**attributes)}
        <worldbody><body><joint name="j0" axis="0 1 0" {joint}/>
        <inertial pos="0 0 0" mass="1" diaginertia="{inertia} {inertia} {inertia}"/>
        </body></worldbody>{actuators(more=actuator)}</mujoco>""")


def pendulum(timestep=0.001, mass=0.2, length=0.1, **attributes):
    """A point mass on a rod that hangs down at zero."""
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco><option timestep="{timestep}" gravity="0 0 -9.80665"/>{extension(**attributes)}
        <worldbody><body><joint name="j0" axis="0 1 0"/>
        <inertial pos="0 0 -{length}" mass="{mass}" diaginertia="1e-9 1e-9 1e-9"/>
        </body></worldbody>{actuators()}</mujoco>""")


def shared(count, plugin="sas", sensor="sar", **attributes):
    """As `extension` and `actuators`, with one instance for all servos and one sensor."""
    attributes = {"parameters": "delay_s 0", **attributes}
    keys = "".join(f'<config key="{k}" value="{v}"/>' for k, v in attributes.items())
    act = "".join(
        f'<plugin joint="j{i}" plugin="{plugin}" instance="all"/>' for i in range(count)
    )
    return (
        f'<extension><plugin plugin="{plugin}"><instance name="all">{keys}</instance></plugin>'
        f'<plugin plugin="{sensor}"><instance name="r"><config key="servo" value="all"/>'
        "</instance></plugin></extension>",
        f'<actuator>{act}</actuator><sensor><plugin plugin="{sensor}" instance="r"/></sensor>',
    )


def arm(
    count=6, timestep=0.001, mass=0.15, length=0.08, floor=False, is_shared=False, **attributes
):
    """An arm of links with a servo in each joint, on a floor that it may touch."""
    instances, moved = extension(count, **attributes), actuators(count)
    if is_shared:
        instances, moved = shared(count, **attributes)
    axes = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"]
    bodies = "".join(
        f'<body pos="0 0 {length if i else 0.05}"><joint name="j{i}" axis="{axes[i % 6]}" '
        f'armature="1e-4"/><geom type="capsule" fromto="0 0 0 0 0 {length}" size=".015" '
        f'mass="{mass}" contype="{int(floor)}" conaffinity="{2 * int(floor)}"/>'
        for i in range(count)
    )
    ground = '<geom type="plane" size="1 1 .1" contype="2" conaffinity="1"/>' if floor else ""
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco><option timestep="{timestep}"/>{instances}
        <worldbody>{ground}{bodies}{"</body>" * count}</worldbody>{moved}</mujoco>""")

"""The engine plugin of MuJoCo that the wheel has."""

import pathlib
from importlib import metadata

# The version that it is linked with follows.
_NAME = "libsmart_actuator-mujoco-"


def mujoco_plugin() -> str:
    """The path of the plugin, for ``mujoco.mj_loadPluginLibrary`` (extra ``mujoco``)."""
    plugin = next(pathlib.Path(__file__).parent.glob(_NAME + "*.so"), None)
    if plugin is None:
        raise FileNotFoundError(
            "this package has no plugin of MuJoCo, expected a released wheel, or the plugin that "
            "bindings/mujoco/build.sh makes"
        )
    expected = plugin.stem[len(_NAME) :]
    try:
        installed = metadata.version("mujoco")
    except metadata.PackageNotFoundError:
        raise ImportError(f"mujoco is not installed, expected mujoco=={expected}") from None
    if installed != expected:
        raise ImportError(
            f"mujoco is {installed}, expected mujoco=={expected}, with which the plugin is linked"
        )
    return str(plugin)

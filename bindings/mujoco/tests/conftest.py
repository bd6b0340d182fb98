import os

import mujoco

mujoco.mj_loadPluginLibrary(os.environ["ACTUATOR_PLUGIN"])

"""State, copies and threads."""

import mujoco
import mujoco.rollout
import numpy as np
import pytest
from models import arm, link

ALL = mujoco.mjtState.mjSTATE_FULLPHYSICS


def kept(model, data):
    state = np.empty(mujoco.mj_stateSize(model, ALL))
    mujoco.mj_getState(model, data, state, ALL)
    return state


def run(model, data, steps, seed=0):
    rng = np.random.default_rng(seed)
    path = []
    for i in range(steps):
        if i % 50 == 0:
            data.ctrl[:] = rng.uniform(-1, 1, model.nu)
        mujoco.mj_step(model, data)
        path.append(np.r_[data.qpos, data.qvel, data.actuator_force, data.sensordata])
    return np.array(path)


@pytest.mark.parametrize("make", [link, arm, lambda: link(plant="first-order", timestep=0.0005)])
def test_a_state_that_is_set_leads_to_the_same_motion_in_any_data(make):
    model = make()
    first = mujoco.MjData(model)
    run(model, first, 333)
    state = kept(model, first)
    expected = run(model, first, 400, seed=1)
    for data in (first, mujoco.MjData(model)):
        run(model, data, 77, seed=2)
        mujoco.mj_setState(model, data, state, ALL)
        # The sensors show the previous step until the next one.
        assert np.array_equal(run(model, data, 400, seed=1), expected)


def test_a_reset_and_a_copy_continue_exactly():
    model = arm()
    data = mujoco.MjData(model)
    expected = run(model, data, 300)
    mujoco.mj_resetData(model, data)
    assert np.array_equal(run(model, data, 200), expected[:200])
    other = mujoco.MjData(model)
    mujoco.mj_copyData(other, model, data)
    assert np.array_equal(run(model, other, 100, seed=5), run(model, data, 100, seed=5))


def test_a_forward_evaluation_changes_nothing():
    model = arm()
    plain, evaluated = mujoco.MjData(model), mujoco.MjData(model)
    for _ in range(200):
        for data in (plain, evaluated):
            data.ctrl[:] = 0.4
        for _ in range(3):
            mujoco.mj_forward(model, evaluated)
        for data in (plain, evaluated):
            mujoco.mj_step(model, data)
        assert np.array_equal(plain.qpos, evaluated.qpos)


def test_rollouts_in_threads_are_those_of_one_thread():
    model = arm()
    states = np.tile(kept(model, mujoco.MjData(model)), (16, 1))
    control = np.random.default_rng(3).uniform(-1, 1, (16, 1, model.nu)).repeat(250, axis=1)
    one, _ = mujoco.rollout.rollout(model, mujoco.MjData(model), states, control)
    threads = [mujoco.MjData(model) for _ in range(2)]
    many, _ = mujoco.rollout.rollout(model, threads, states, control)
    # Time and motion; of the servos' states, bytes between their values have any content.
    motion = slice(0, 1 + model.nq + model.nv)
    assert np.array_equal(one[..., motion], many[..., motion])
    assert not np.array_equal(one[0][..., motion], one[1][..., motion])

import numpy as np
import pytest

import smart_actuator as sa

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from smart_actuator.gymnasium import ActuatorEnv, ActuatorVectorEnv, posterior  # noqa: E402


def test_the_environment_passes_the_checker_of_gymnasium():
    check_env(gymnasium.make("smart_actuator/Follow-v0").unwrapped, skip_render_check=True)
    check_env(ActuatorEnv(plant="bench", steps=5), skip_render_check=True)


def episode(env, seed, steps=30):
    rng = np.random.default_rng(7)
    path = [env.reset(seed=seed)[0]]
    for _ in range(steps):
        observation, reward, *_ = env.step(rng.uniform(-1, 1, (env.num_envs, 1)))
        path += [observation, reward[:, None]]
    return np.concatenate([p.ravel() for p in path])


def test_a_seed_decides_everything_and_episodes_begin_again():
    def vector():
        def randomise(rng, count):
            return {"position_gain": rng.uniform(6, 10, count)}

        return ActuatorVectorEnv(50, randomise=randomise, steps=12, encoder_noise_deg=0.05)

    first = episode(vector(), 3)
    env = vector()
    assert np.array_equal(episode(env, 3), first)
    assert np.array_equal(episode(env, 3), first)
    assert not np.array_equal(episode(env, 4), first)


def test_an_episode_that_was_truncated_begins_in_the_next_step():
    env = gymnasium.make_vec("smart_actuator/Follow-v0", num_envs=3, vectorization_mode="vector_entry_point", steps=4)
    env.reset(seed=0)
    ends = [env.step(np.ones((3, 1)))[3].all() for _ in range(11)]
    assert ends == [False, False, False, True] + [False] * 4 + [True] + [False] * 2
    # The step in which episodes begin does not count: at rest, with reward 0.
    env.reset(seed=0)
    for _ in range(4):
        env.step(np.ones((3, 1)))
    observation, reward, *_ = env.step(np.ones((3, 1)))
    assert not reward.any() and not observation[:, 1:3].any()


def test_a_policy_that_commands_the_target_is_better_than_none():
    totals = []
    for factor in (1.0, 0.0):
        env = ActuatorVectorEnv(20)
        observation, _ = env.reset(seed=1)
        total = 0.0
        for _ in range(100):
            observation, reward, *_ = env.step(factor * observation[:, :1])
            total += reward.sum()
        totals.append(total)
    assert totals[0] > 0.5 * totals[1]


def test_parameters_are_drawn_from_the_posterior_of_a_fit():
    trace = sa.simulate("black-box-1", input="3-2-1-1", every=80)
    rng = np.random.default_rng(0)
    measured = trace.angle_deg + rng.normal(0, 0.05, len(trace.time_s))
    found = sa.identify(
        {"time_s": trace.time_s, "command_deg": trace.command_deg, "angle_deg": measured},
        models="black-box-1",
        threads=1,
    )["models"][0]
    drawn = posterior(found)(np.random.default_rng(1), 4000)
    pole = next(p for p in found["parameters"] if p["name"] == "pole_rad_s")
    # Standard errors of 4,000 draws: 1.6 % of the deviation for the mean, 1.1 % of it.
    error = pole["standard_error_coloured"]
    assert np.mean(drawn["pole_rad_s"]) == pytest.approx(pole["estimate"], abs=0.08 * error)
    assert np.std(drawn["pole_rad_s"]) == pytest.approx(error, rel=0.06)
    # What is not drawn keeps its estimate, and not the default of the simulator.
    only = posterior(found, only=["delay_s"])(np.random.default_rng(1), 3)
    assert only["pole_rad_s"].tolist() == [pole["estimate"]] * 3
    assert len(set(only["delay_s"])) == 3
    env = ActuatorVectorEnv(8, model="black-box-1", randomise=posterior(found, widen=3.0))
    episode(env, 0, steps=3)

"""Tests of the package against a daemon that the environment names: SHATTER_TEST_SERVICE and SHATTER_TEST_OBJECT."""

import functools
import gc
import math
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import shatter

SERVICE = os.environ["SHATTER_TEST_SERVICE"]
OBJECT = os.environ["SHATTER_TEST_OBJECT"]


@pytest.fixture(scope="module")
def service():
    return shatter.wait_for(SERVICE)


@pytest.fixture(scope="module")
def body(service):
    return service.object(OBJECT)


@functools.cache
def top():
    """The highest vertex, m."""
    whole = shatter.connect(SERVICE).object(OBJECT).even(1).wait()[0]
    return whole.center_m + whole.positions[whole.positions[:, 1].argmax()]


def contact_on(body, scale=1.0):
    return shatter.Contact(top(), (0.0, -2.0 * scale, 0.0))


def volume(positions, triangles):
    a, b, c = (positions[triangles[:, k]].astype(float) for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def test_fragments_are_closed_and_add_up(body):
    result = body.strike(contact_on(body), degree=12).wait()
    assert len(result) == len(list(result)) >= 12 and not result.is_whole
    for fragment in result:
        assert fragment.is_closed()
        assert volume(fragment.positions, fragment.triangles) == pytest.approx(fragment.volume_m3, rel=1e-5)
        assert np.linalg.eigvalsh(fragment.inertia_kg_m2).min() > 0
        assert sum(run.triangle_count for run in fragment.runs) == len(fragment.triangles)
    assert sum(f.volume_m3 for f in result) == pytest.approx(body.facts.volume_m3, rel=1e-6)
    assert len(result.positions) == sum(len(f.positions) for f in result)
    assert result[-1].id == result[len(result) - 1].id == len(result) - 1
    with pytest.raises(IndexError):
        result[len(result)]


def test_arrays_are_views_that_cannot_be_written(body):
    result = body.strike(contact_on(body), degree=6).wait()
    first, again = result[0].positions, result[0].positions
    assert np.shares_memory(first, again) and np.shares_memory(first, result.positions)
    assert not first.flags.owndata and not first.flags.writeable
    assert first.dtype == np.float32 and result[0].triangles.dtype == np.uint32
    with pytest.raises(ValueError):
        first.flags.writeable = True
    with pytest.raises(ValueError):
        first[0, 0] = 1.0


def test_arrays_outlive_the_result_and_release_waits_for_them(body):
    result = body.strike(contact_on(body), degree=6).wait()
    array = result[0].positions
    copied = array.copy()
    with pytest.raises(BufferError):
        result.release()
    del result
    gc.collect()
    for seed in range(8):
        body.strike(contact_on(body), degree=6, seed=seed).wait().release()
    released = body.strike(contact_on(body), degree=6).wait()
    released.release()
    with pytest.raises(shatter.ArgumentError, match="released"), released:
        pass
    assert np.array_equal(array, copied)
    with body.strike(contact_on(body), degree=6).wait() as other:
        inner = other[0].positions
    assert np.isfinite(inner).all()
    with pytest.raises(ValueError):
        other.summary


def test_results_that_are_freed_do_not_use_up_the_service(body):
    for seed in range(300):
        assert len(body.strike(contact_on(body), degree=2, seed=seed).wait()) >= 2


def test_same_strike_same_bytes(body):
    hashes = {body.strike(contact_on(body), degree=9, seed=7).wait().output_hash for _ in range(3)}
    assert len(hashes) == 1
    assert hashes != {body.strike(contact_on(body), degree=9, seed=8).wait().output_hash}


def test_effects_bring_what_they_say(body):
    effects = ["normals", "uv", "hulls", "bonds", "debris", "release"]
    result = body.strike(contact_on(body), degree=8, enable=effects).wait()
    fragment = result[0]
    assert fragment.normals.shape == fragment.positions.shape
    assert np.allclose(np.linalg.norm(fragment.normals, axis=1), 1.0, atol=1e-3)
    assert fragment.uvs.shape == (len(fragment.positions), 2)
    assert fragment.linear_m_s.shape == (3,)
    hulls = [f.hull for f in result if f.hull is not None]
    assert hulls and all(volume(hull.positions, hull.triangles) > 0 for hull in hulls)
    assert result.bonds and all(bond.area_m2 > 0 for bond in result.bonds)
    assert body.strike(contact_on(body), degree=8, enable="hulls").wait()[0].hull is not None
    plain = body.strike(contact_on(body), degree=8).wait()
    assert plain[0].normals is plain[0].outer_uvs2 is plain[0].outer_colors is None and plain[0].hull is None and not plain.bonds


def test_conventions_name_the_same_points_otherwise(body):
    unreal = shatter.connect(SERVICE, convention="unreal").object(OBJECT)
    x, y, z = top()
    theirs = unreal.strike(shatter.Contact((100 * x, 100 * z, 100 * y), (0.0, 0.0, -200.0)), degree=6).wait()
    ours = body.strike(contact_on(body), degree=6).wait()
    for a, b in zip(ours, theirs):
        assert np.allclose(100 * a.positions[:, [0, 2, 1]], b.positions, rtol=1e-5, atol=1e-6)
        assert a.mass_kg == pytest.approx(b.mass_kg)


def test_kept_fragments_are_struck_again(service, body):
    result = body.strike(contact_on(body), degree=4, keep=True).wait()
    largest = max(result, key=lambda fragment: fragment.mass_kg)
    positions = largest.positions
    contact = shatter.Contact(largest.center_m + positions[positions[:, 1].argmax()], (0.0, -2.0, 0.0))
    again = body.strike(contact, degree=3, origin=(result.handle, largest.id)).wait()
    assert sum(f.mass_kg for f in again) == pytest.approx(largest.mass_kg, rel=1e-5)
    service.release(result.handle)
    with pytest.raises(shatter.ServiceError) as refused:
        body.strike(contact, origin=(result.handle, largest.id)).wait()
    assert refused.value.kind == "unknown_handle"


def test_even_pieces_and_thresholds(body):
    even = body.even(16).wait()
    assert even.summary.sites == 16
    assert sum(f.volume_m3 for f in even) == pytest.approx(body.facts.volume_m3, rel=1e-6)
    factor = body.threshold_factor(contact_on(body))
    just, below = (body.strike(contact_on(body, share * factor), degree=8).wait() for share in (1.0, 0.5))
    assert just.summary.strain_j == pytest.approx(4.0 * below.summary.strain_j, rel=1e-6)
    assert body.strike(contact_on(body, 0.9 * factor)).wait().is_whole
    assert body.strike(contact_on(body, 1e-6 * factor)).wait().summary.strain_j is None


def test_the_criterion_by_strength_balances_energies(body):
    summary = body.strike(contact_on(body), degree=8, criterion="strength", enable="release").wait().summary
    assert summary.criterion == "strength" and summary.stress_over_strength > 0.0
    lacking = summary.surface_j + summary.released_j - summary.strain_j
    assert (summary.deficit_j or 0.0) == pytest.approx(max(lacking, 0.0), abs=1e-9 * summary.surface_j)
    plain = body.strike(contact_on(body), degree=8).wait().summary
    assert plain.criterion == "paper" and plain.surface_j is plain.stress_over_strength is None
    with pytest.raises(shatter.ArgumentError):
        body.strike(contact_on(body), criterion="griffith")


def test_partners_limit_the_strain_energy(body):
    def struck(partner):
        contact = contact_on(body)
        contact = shatter.Contact(contact.point, contact.impulse, partner=partner)
        return body.strike(contact, degree=8).wait().summary

    free, ball = struck(None), shatter.ContactPartner(0.5, 2.0, id=3, center=(0, 0, 1), inertia=(1, 1, 1, 0, 0, 0))
    assert free.impactor_j is free.remainder_j is free.load_factor is None
    assert (ball.mass_kg, ball.speed, ball.id, ball.center[2], ball.inertia[0]) == (0.5, 2.0, 3, 1.0, 1.0)
    limited = struck(ball)
    assert 0.0 < limited.impactor_j <= 0.5 * 0.5 * 2.0**2
    assert limited.strain_j == pytest.approx(min(free.strain_j, limited.impactor_j), rel=1e-9)
    assert limited.remainder_j == pytest.approx(limited.impactor_j - limited.strain_j, abs=1e-9 * limited.impactor_j)
    assert limited.load_factor**2 == pytest.approx(limited.strain_j / free.strain_j, rel=1e-9)
    apart = struck(shatter.ContactPartner(math.inf, -2.0))
    assert (apart.impactor_j, apart.load_factor, apart.fracture_degree) == (0.0, 0.0, 1)
    with pytest.raises(shatter.ArgumentError, match="^inertia must be 6 numbers"):
        shatter.ContactPartner(1.0, 1.0, inertia=(1, 2, 3))
    with pytest.raises(TypeError):
        shatter.Contact((0, 0, 0), (1, 0, 0), partner=1.0)


def test_hertz_of_a_steel_ball_on_steel():
    """A ball of 1 kg at 1 m/s against a half-space, beside the closed form (Johnson 1985, 11.4)."""
    young, poisson, radius, mass = 210e9, 0.3, 0.03, 1.0
    found = shatter.hertz((mass, radius, young, poisson), (math.inf, math.inf, young, poisson), 1.0)
    modulus = young / (2 * (1 - poisson**2))
    assert found.approach_m == pytest.approx((15 * mass / (16 * modulus * math.sqrt(radius))) ** 0.4)
    assert found.duration_s == pytest.approx(2.943275 * found.approach_m, rel=1e-6)
    with pytest.raises(ValueError):
        shatter.hertz((0.0, 0.1, young, poisson), (1.0, 0.1, young, poisson), 1.0)
    with pytest.raises(shatter.ArgumentError, match="^mass_kg: 1e-320 is too small"):
        shatter.hertz((1e-320, 0.1, young, poisson), (1.0, 0.1, young, poisson), 1.0)


@pytest.mark.parametrize(
    "strike, kind",
    [
        (lambda body: body.strike(shatter.Contact((0, 0, 0), (0, 0, 0))), "impulse"),
        (lambda body: body.strike(shatter.Contact((1e6, 0, 0), (1, 0, 0))), "contact_too_far"),
        (lambda body: body.strike(shatter.Contact(top(), (0, -1, 0), radius=5.0)), "contact_radius"),
        (lambda body: body.strike(*[contact_on(body)] * 9), "contact_count"),
        (lambda body: body.strike(shatter.Contact(top(), (0, -1, 0), partner=shatter.ContactPartner(0, 1))), "contact_partner"),
        (lambda body: body.strike(contact_on(body), degree=0), "degree"),
        (lambda body: body.strike(contact_on(body), gamma_j_m2=-1.0), "gamma"),
        (lambda body: body.strike(contact_on(body), enable=["sparkles"]), "unknown_effect"),
        (lambda body: body.strike(contact_on(body), origin=(12345, 0)), "unknown_handle"),
        (lambda body: body.strike(contact_on(body), degree=9, fragments_max=2), "cap_exceeded"),
    ],
)
def test_errors_name_their_rule(body, strike, kind):
    with pytest.raises(shatter.ServiceError) as refused:
        strike(body).wait()
    error = refused.value
    assert error.kind == kind and error.fault == "caller" and not error.retry and str(error)


def test_all_errors_have_one_base(body):
    assert issubclass(shatter.ShatterError, Exception)
    for error in [shatter.ServiceError, shatter.ArgumentError]:
        assert issubclass(error, shatter.ShatterError) and error.__module__ == "shatter"
    with pytest.raises(shatter.ShatterError) as refused:
        shatter.connect("nobody-here")
    assert type(refused.value) is shatter.ServiceError
    with pytest.raises(shatter.ShatterError) as wrong:
        body.strike(contact_on(body), quality="fine")
    assert type(wrong.value) is shatter.ArgumentError and isinstance(wrong.value, ValueError)


def test_options_have_names(body):
    with pytest.raises(TypeError):
        body.strike(contact_on(body)).wait(60.0)


def test_wrong_arguments_are_named(body, service):
    for wrong in [(1.0, 2.0), "abc", None, (1.0, 2.0, "x"), (math.nan, 0, 0), 3, np.zeros((3, 3))]:
        for key in ["point", "impulse", "ray"]:
            if key == "ray" and wrong is None:
                continue
            vectors = {"point": top(), "impulse": (0, -2, 0), key: wrong}
            with pytest.raises(shatter.ArgumentError, match=rf"^{key} must be 3 finite numbers, for example {key}=\("):
                shatter.Contact(**vectors)
    for key in ["origin", "direction"]:
        with pytest.raises(shatter.ArgumentError, match=f"^{key} must be 3 finite numbers"):
            body.aim(**{"origin": (0, 1, 0), "direction": (0, -1, 0), key: [1, 2]})
    for wrong in [-1, 2**70, 2**200, 1.5, "x"]:
        for key in ["seed", "iterations", "fragments_max", "bytes_max"]:
            largest = {"iterations": 10_000, "fragments_max": 2**32 - 1}.get(key, 2**64 - 1)
            least = int(key.endswith("_max"))
            with pytest.raises(shatter.ArgumentError, match=f"^{key} must be a whole number from {least} to {largest}, "):
                body.strike(contact_on(body), **{key: wrong})
        with pytest.raises(shatter.ArgumentError, match=r"^origin must be a pair .*origin=\(result.handle, fragment.id\)"):
            body.strike(contact_on(body), origin=(wrong, 0))
        with pytest.raises(shatter.ArgumentError, match="^fragment must be a pair "):
            body.aim((0, 1, 0), (0, -1, 0), fragment=(0, wrong))
        with pytest.raises(shatter.ArgumentError, match="^pieces must be a whole number"):
            body.even(wrong)
        with pytest.raises(shatter.ArgumentError, match="^handle must be a whole number"):
            service.release(wrong)
    with pytest.raises(shatter.ArgumentError, match="^seed must be a whole number from 0 to [0-9]*, not True"):
        body.strike(contact_on(body), seed=True)
    for key in ["fragments_max", "bytes_max"]:
        with pytest.raises(shatter.ArgumentError, match=f"^{key} must be .* or None for no limit, not 0"):
            body.strike(contact_on(body), **{key: 0})
    for key in ["error", "time_ms", "gamma_j_m2"]:
        with pytest.raises(shatter.ArgumentError, match=f"^{key} must be a number, not 'x'"):
            body.strike(contact_on(body), **{key: "x"})
    with pytest.raises(shatter.ArgumentError, match="^name must be a str that UTF-8 can hold"):
        service.object("\udc80")
    with pytest.raises(shatter.ServiceError) as caught:
        service.object("x" * 65)
    assert caught.value.kind == "object_name"
    with pytest.raises(shatter.ArgumentError, match="^one must be 4 numbers: mass"):
        shatter.hertz(1.0, (1.0, 0.1, 70e9, 0.2), 1.0)
    assert len(body.strike(contact_on(body), degree=3, seed=np.int64(7), iterations=None).wait()) >= 3
    with pytest.raises(ValueError):
        body.strike()
    for wrong in [-1, 2**32, 2.5, [3], True]:
        with pytest.raises(ValueError, match=rf"^degree: .* is not a whole number from 1 to {body.facts.degree_max}, nor one of closed_form"):
            body.strike(contact_on(body), degree=wrong)
    for key in ["enable", "disable"]:
        for wrong in [3, [3], {"hulls": 1.0}.values(), b"hulls"]:
            with pytest.raises(ValueError, match=rf"^{key} must be a list of effect names, e.g. {key}=\['hulls'\]"):
                body.strike(contact_on(body), **{key: wrong})
        with pytest.raises(shatter.ServiceError, match="did you mean `hulls`"):
            body.strike(contact_on(body), **{key: "hull"})
    with pytest.raises(shatter.ServiceError, match="x{200}… .100000 bytes.") as long:
        service.object("x" * 100_000)
    assert len(str(long.value)) < 500 and len(long.value.at) < 300
    for keywords in [{"degree": "many"}, {"quality": "fine"}, {"lift": "up"}, {"elastic": "no"}]:
        (key,) = keywords
        with pytest.raises(ValueError, match=f"^{key}: .* is not one of "):
            body.strike(contact_on(body), **keywords)
    with pytest.raises(shatter.ArgumentError, match="^timeout_s must be a number of seconds from 0 to 1.8e19, not -1.0"):
        body.strike(contact_on(body)).wait(timeout_s=-1.0)
    with pytest.raises(shatter.ArgumentError, match="^deadline_s must be a number of seconds from 0 to 1.8e19, not nan"):
        body.strike(contact_on(body), deadline_s=math.nan)
    with pytest.raises(shatter.ArgumentError, match=r"^deadline_s must be .* to 1.8e19, not 1e\+300"):
        body.strike(contact_on(body), deadline_s=1e300)
    for name in ["no such object", "", "with\0zero", "ä" * 500]:
        with pytest.raises(shatter.ServiceError):
            service.object(name)
    for name in ["", "a/b", "x" * 99]:
        with pytest.raises(shatter.ServiceError):
            shatter.connect(name)
    with pytest.raises(shatter.ServiceError) as absent:
        shatter.connect("nobody-here")
    assert absent.value.kind == "no_daemon" and absent.value.fault == "environment"


def test_names_that_do_not_exist_are_explained(service, body):
    result = body.strike(contact_on(body), degree=4).wait()
    for owner, name, wanted in [
        (result, "fragments", "'FractureResult' has no attribute 'fragments'; the result is a sequence of its fragments"),
        (result, "fragments", "it has `bonds`, `debris`, `handle`, "),
        (result, "sumary", "did you mean `summary`[?]; it has "),
        (result[0], "mass", "did you mean `mass_kg`"),
        (result.summary, "degree", "`fracture_degree`"),
        (body, "hit", "it has `aim`, `even`, `facts`, `name`, `strike`, `threshold_factor`"),
        (service, "obect", "did you mean `object`, `objects`"),
    ]:
        with pytest.raises(AttributeError, match=wanted):
            getattr(owner, name)
        assert not hasattr(owner, name)
    contact = contact_on(body)
    for call, wanted in [
        (lambda: body.strike(contact, effects=["hulls"]), "has no argument 'effects'; effects are switched by `enable="),
        (lambda: body.strike(point=[1, 2]), "has no argument 'point'; contacts come first, without a keyword"),
        (lambda: body.strike(contact, enabled="hulls"), "did you mean `enable`.*; its keywords are `degree`, `quality`, "),
        (lambda: body.even(3, sead=1), "did you mean `seed`"),
        (lambda: shatter.connect(timeout=3), r"connect\(\) has no argument 'timeout'; did you mean `timeout_s`"),
        (lambda: shatter.Contact(top(), (0, -1, 0), raduis=1.0), r"Contact\(\) has no argument 'raduis'; did you mean `radius`"),
        (lambda: body.strike([contact, contact]), r"not list; write an asterisk .*: strike\(\*contacts\)$"),
        (lambda: body.strike(top()), "contacts are of the type shatter.Contact, not "),
        (lambda: shatter.Contact(top(), (0, -1, 0), color=1.0), "there are `point`, `impulse`, `duration_s`, `radius`, `ray`"),
    ]:
        with pytest.raises(TypeError, match=wanted):
            call()


def test_without_a_name_the_environment_names_the_service(monkeypatch):
    monkeypatch.setenv("SHATTER_SERVICE", SERVICE)
    assert shatter.connect().object(OBJECT).name == OBJECT
    monkeypatch.setenv("SHATTER_SERVICE", "nobody-here")
    for connect in [shatter.connect, functools.partial(shatter.wait_for, timeout_s=0.01)]:
        with pytest.raises(shatter.ServiceError) as absent:
            connect()
        assert absent.value.kind == "no_daemon" and absent.value.at == "nobody-here"
    monkeypatch.setenv("SHATTER_SERVICE", "a b")
    with pytest.raises(shatter.ServiceError) as odd:
        shatter.connect()
    assert odd.value.kind == "service_name" and odd.value.at == "SHATTER_SERVICE"


def test_a_ray_finds_the_point(body):
    low, high = np.array(body.facts.bounds_m)
    origin = (low + high) / 2 + (0.0, 1.0, 0.0)
    hit = body.aim(origin, (0.0, -3.0, 0.0))
    assert hit.normal[1] > 0.7 and hit.distance == pytest.approx(origin[1] - hit.point[1])
    # A ray hits the surface of the mesh.
    assert (low - 1e-9 <= hit.point).all() and (hit.point <= high + 1e-9).all()
    result = body.strike(shatter.Contact(origin, (0.0, -2.0, 0.0), ray=(0.0, -1.0, 0.0)), degree=5, keep=True).wait()
    assert result.hit.point == hit.point
    assert body.strike(contact_on(body), degree=5).wait().hit is None
    fragment = max(result, key=lambda fragment: fragment.mass_kg)
    onto = body.aim(fragment.center_m + (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), fragment=(result.handle, fragment.id))
    assert onto.point[1] > fragment.center_m[1]
    with pytest.raises(shatter.ServiceError) as missed:
        body.aim(high + 1.0, (1.0, 0.0, 0.0))
    assert missed.value.kind == "ray_missed" and "closest" in str(missed.value)
    with pytest.raises(shatter.ServiceError) as still:
        body.aim(origin, (0.0, 0.0, 0.0))
    assert still.value.kind == "ray"


def test_names_that_are_nearly_right_are_told(service, body):
    with pytest.raises(shatter.ServiceError, match=f"did you mean `{OBJECT}`"):
        service.object(OBJECT + "x")
    with pytest.raises(ValueError, match="did you mean `film`"):
        body.strike(contact_on(body), quality="flim")
    with pytest.raises(ValueError, match="flat|finite radius"):
        shatter.hertz((1.0, math.inf, 70e9, 0.2), (math.inf, math.inf, 33e9, 0.2), 1.0)


def test_tickets_poll_cancel_and_are_spent(body):
    ticket = body.strike(contact_on(body), degree=5)
    deadline = time.monotonic() + 60
    while (result := ticket.poll()) is None and time.monotonic() < deadline:
        assert ticket.state in {"waiting", "computing", "ended"}
    assert len(result) >= 5 and ticket.state == "ended"
    with pytest.raises(shatter.ServiceError) as spent:
        ticket.wait()
    assert spent.value.kind == "ticket_spent" and not spent.value.retry
    other = body.strike(contact_on(body), degree=5)
    other.cancel()
    with pytest.raises(shatter.ServiceError) as refused:
        other.wait()
    assert refused.value.kind == "canceled"


def test_what_is_late_says_so(body):
    kinds = set()
    for seed in range(50):
        try:
            body.strike(contact_on(body), degree=200, seed=seed, deadline_s=0.0005).wait()
        except shatter.ServiceError as error:
            kinds.add(error.kind)
    assert kinds == {"late"}
    with pytest.raises(shatter.ServiceError) as refused:
        body.strike(contact_on(body), degree=200).wait(timeout_s=0.0)
    assert refused.value.kind == "late"


def test_threads_share_one_connection(body):
    expected = body.strike(contact_on(body), degree=7, seed=1).wait().output_hash
    found, errors = [], []

    def work():
        try:
            for _ in range(5):
                found.append(body.strike(contact_on(body), degree=7, seed=1).wait().output_hash)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert not errors and found == [expected] * 20


def test_threads_share_one_result(body):
    code = f"""
import sys, threading, shatter
sys.setswitchinterval(1e-6)
body = shatter.wait_for({SERVICE!r}).object({OBJECT!r})
result = body.strike(shatter.Contact({top().tolist()}, (0.0, -2.0, 0.0)), degree=20).wait()

def work():
    for _ in range(20):
        for fragment in result:
            fragment.positions.sum()
            fragment.triangles.sum()

threads = [threading.Thread(target=work) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
"""
    # A process of its own: threads that wait for each other could not be ended here.
    for _ in range(3):
        subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_one_ticket_in_two_threads(body):
    ticket, results, spent = body.strike(contact_on(body), degree=7), [], []

    def work():
        try:
            results.append(ticket.wait())
        except shatter.ServiceError as error:
            spent.append(error.kind)

    threads = [threading.Thread(target=work) for _ in range(2)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(results) == 1 and spent == ["ticket_spent"]


def fork(child):
    """Runs ``child`` in a forked process, which then ends as Python programs do; returns its exit code."""
    sys.stdout.flush()
    pid = os.fork()
    if pid == 0:
        try:
            child()
            sys.exit(0)
        except BaseException as error:
            # Destructors run, as at the end of a program, but nothing of pytest.
            code = error.code if isinstance(error, SystemExit) else 1
            gc.collect()
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_fork_takes_nothing_from_its_parent():
    held = {"service": shatter.connect(SERVICE)}
    held["body"] = held["service"].object(OBJECT)
    held["result"] = held["body"].strike(contact_on(held["body"]), degree=7, seed=1).wait()
    expected = held["result"].output_hash
    held["ticket"] = held["body"].strike(contact_on(held["body"]), degree=7, seed=1)
    assert fork(held.clear) == 0
    assert held["ticket"].wait().output_hash == expected
    for _ in range(3):
        assert held["body"].strike(contact_on(held["body"]), degree=7, seed=1).wait().output_hash == expected

    def child():
        with pytest.raises(shatter.ServiceError) as lost:
            held["ticket"].poll()
        assert lost.value.kind == "lost" and "fork" in str(lost.value)
        again = held["body"].strike(contact_on(held["body"]), degree=7, seed=1).wait()
        assert again.output_hash == expected

    held["ticket"] = held["body"].strike(contact_on(held["body"]), degree=7, seed=1)
    assert fork(child) == 0
    assert held["ticket"].wait().output_hash == expected


def test_without_numpy_the_import_says_what_to_install():
    code = "import sys; sys.modules['numpy'] = None; import shatter"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr.endswith("ModuleNotFoundError: shatter returns numpy arrays: `pip install numpy`\n"), run.stderr


def test_ctrl_c_ends_a_wait():
    # Programs that a script starts in the background ignore the signal, and so do their children.
    script = (
        "import shatter, signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "print('on', flush=True); shatter.wait_for('nobody-here', timeout_s=600)"
    )
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "on\n"
    child.send_signal(signal.SIGINT)
    _, error = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in error


def test_files(body, tmp_path):
    result = body.strike(contact_on(body), degree=5, enable=["hulls", "bonds"]).wait()
    result.write_glb(tmp_path / "a.glb")
    with pytest.raises(shatter.ArgumentError, match="write_obj"):
        result.write_glb(tmp_path / "a.obj")
    with pytest.raises(shatter.ArgumentError, match="write_mjcf writes .xml files, not `.*a.glb`"):
        result.write_mjcf(tmp_path / "a.glb")
    with pytest.raises(shatter.ArgumentError, match="`.*a.obj` is the name of a file; pass the name of a folder"):
        result.write_obj(tmp_path / "a.obj")
    result.write_obj(str(tmp_path / "pieces"))
    for write in [result.write_glb, result.write_obj, result.write_mjcf]:
        with pytest.raises(shatter.ArgumentError, match="is empty; it must name the output"):
            write("")
        for wrong in [5, None, b"a.glb"]:
            with pytest.raises(shatter.ArgumentError, match="must be a str, or an os.PathLike of one, not"):
                write(wrong)
    result.write_mjcf(tmp_path / "a.xml")
    assert (tmp_path / "a.glb").read_bytes()[:4] == b"glTF"
    assert len(list((tmp_path / "pieces").glob("fragment_[0-9]*[0-9].obj"))) == len(result)
    assert (tmp_path / "a.xml").read_text().lstrip().startswith("<")
    result.write_glb(tmp_path / "new" / "a.glb")
    assert (tmp_path / "new" / "a.glb").exists()
    with pytest.raises(shatter.ServiceError) as refused:
        result.write_glb(tmp_path / "a.glb" / "a.glb")
    assert refused.value.kind == "output"

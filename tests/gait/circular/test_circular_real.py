"""Phases of real animals: every number that two other libraries gave for the same events.

Computed with pingouin and pycircstat2 from hand-scored contacts: phase of the lift-offs of
one leg within the cycles from lift-off to lift-off of another; all lift-offs inside the cycle.
Of a tardigrade ("bear") and the first fly the events are at hand; the rows of two more flies and
of a mouse (VGL) are checked from n, mean and r on.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from pawnb.gait.circular import circular_sd, mean_interval, mean_vector, rayleigh_p
from pawnb.gait.circular.describe import angular_deviation
from pawnb.gait.phases import phase_lags

# animal, leg/reference, n, mean (degrees), r, circular SD, angular SD, z, p (Zar), interval
TABLE = """
bear R1/L1 11 131.702978 0.31170264 87.484694 67.224206 1.06874386 0.351318 nan nan
bear R2/L2 11 151.228610 0.10494213 121.660034 76.659007 0.12114137 0.890326 nan nan
bear R3/L3 12 318.018269 0.26434039 93.464772 69.498605 0.83851009 0.441153 nan nan
bear R4/L4 13 189.659147 0.82670247 35.348331 33.731357 8.88468072 2.34657e-05 166.5803 212.7380
bear L2/L3 12 168.022309 0.74414618 44.048329 40.985815 6.64504251 0.000549743 139.5552 196.4894
bear L1/L2 10 171.633875 0.69434076 48.939614 44.797770 4.82109085 0.00526318 136.2993 206.9684
bear R2/R3 11 188.625897 0.33785105 84.407794 65.934919 1.25557665 0.291098 nan nan
bear R1/R2 11 208.227544 0.64479622 53.676144 48.292137 4.57338378 0.0074798 171.0896 245.3655
fly1 RF/LF 25 195.984177 0.94232823 19.748621 19.458943 22.19956249 2.13088e-14 187.6614 204.3069
fly1 RM/LM 26 201.430207 0.75038247 43.421904 40.483232 14.63992000 3.62471e-08 183.1990 219.6614
fly1 RH/LH 26 184.828277 0.79663612 38.635991 36.540505 16.50035669 2.18859e-09 168.1345 201.5220
fly1 LF/LM 28 111.840309 0.81330273 36.834714 35.011169 18.52091745 1.34868e-10 96.2897 127.3910
fly1 RM/LF 26 89.758691 0.78251995 40.126347 37.787429 15.92077422 5.37977e-09 72.6122 106.9052
fly1 LH/LF 25 146.189353 0.86638110 30.687269 29.619081 18.76540507 3.47023e-11 131.2459 161.1328
fly2 RF/LF 58 176.955611 0.88237519 28.663691 27.789908 45.15798613 6.34311e-27 167.6024 186.3088
fly2 RM/LM 59 198.704716 0.88636422 28.142358 27.314621 46.35285008 9.3245e-28 189.5022 207.9073
fly2 RH/LH 57 183.440835 0.92457158 22.691560 22.253849 48.72545848 1.0759e-30 177.1942 189.6875
fly2 LF/LM 58 151.896216 0.90394141 25.750068 25.113412 47.39238440 5.35701e-29 144.7848 159.0077
fly2 RM/LF 57 47.845903 0.95163325 18.041451 17.820140 51.61953261 4.22974e-34 42.9558 52.7361
fly2 LH/LF 58 58.267994 0.89935282 26.390894 25.706232 46.91245894 1.54892e-28 49.2082 67.3278
fly3 RF/LF 52 176.903928 0.94563087 19.158220 18.893562 46.49932230 2.36935e-30 171.4390 182.3688
fly3 RM/LM 51 169.580772 0.88135196 28.796272 27.910519 39.61584495 1.26161e-23 159.5693 179.5923
fly3 RH/LH 51 173.319685 0.92517770 22.596550 22.164256 43.65364289 1.56076e-27 166.7310 179.9084
fly3 LF/LM 51 169.343781 0.93046506 21.752900 21.366785 44.15402632 4.44647e-28 163.0207 175.6669
fly3 RM/LF 51 0.743540 0.90169059 26.065971 25.405934 41.46534223 2.54334e-25 353.0356 8.4514
fly3 LH/LF 51 20.123478 0.90705257 25.308250 24.703377 41.95996228 8.45659e-26 12.6640 27.5830
VGL Forelimbs 9 174.745963 0.83951405 33.890061 32.460570 6.34305449 0.000562781 146.8066 202.6853
VGL Hindlimbs 9 187.369023 0.69527992 48.848861 44.728895 4.35072755 0.0090584 149.6223 225.1158
VGL Ipsi 9 143.208606 0.74322521 44.140527 41.059516 4.97145339 0.00405325 109.1868 177.2304
VGL Contra 9 124.518175 0.84677946 33.044815 31.717293 6.45331914 0.000473075 96.9817 152.0547
VGL CF-IH 9 327.493892 0.76831502 41.598113 39.001972 5.31277172 0.00255026 295.2110 359.7768
VGL IF-CH 9 311.996097 0.95598180 17.191866 17.000190 8.22511081 1.76603e-05 299.0546 324.9376
"""
ROWS = [line.split() for line in TABLE.strip().splitlines()]
WITH_EVENTS = [row for row in ROWS if row[0] in ("bear", "fly1")]


def lift_offs(real_data, animal, leg):
    if animal == "bear":
        table = pd.read_csv(real_data("tardigrade-8leg-events") / "events_long.csv")
        up = table[(table["event"] == "up") & (table["leg"] == leg)]
        return np.sort(up["time_s"].to_numpy())
    name = f"ground_truth_contact_{animal}.csv"
    contact = pd.read_csv(real_data("fly-6leg-contact") / name)[leg].to_numpy()
    return np.flatnonzero(np.diff(contact) == -1)


@pytest.mark.parametrize("row", WITH_EVENTS, ids=lambda row: " ".join(row[:2]))
def test_mean_vector_from_the_events(real_data, row):
    animal, pair, n, mean, r = row[0], row[1].split("/"), int(row[2]), float(row[3]), float(row[4])
    own, base = (lift_offs(real_data, animal, leg) for leg in pair)
    _, phases = phase_lags(own, np.column_stack((base[:-1], base[1:])))
    found = mean_vector(phases)
    assert found.n == n
    assert found.mean * 360 == pytest.approx(mean, abs=5e-6)
    assert found.r == pytest.approx(r, abs=5e-9)
    # a twin with one lift-off later by a hundredth of its cycle is noticed
    phases[0] += 0.01
    assert mean_vector(phases).r != pytest.approx(r, abs=5e-9)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: " ".join(row[:2]))
def test_what_follows_from_the_mean_vector(row):
    n, mean, r, circular, angular, z, zar, low, high = (float(v) for v in row[2:])
    n = int(n)

    def found(r):
        ends = [360 * v for v in mean_interval(mean / 360, r, n)]
        return [360 * circular_sd(r), 360 * angular_deviation(r), n * r**2,
                rayleigh_p(n, r, method="zar"), *ends]  # fmt: skip

    # r is printed with 8 digits, which costs z and p some of theirs
    expected = [pytest.approx(v, abs=d) for v, d in
                ((circular, 5e-5), (angular, 5e-5), (z, 1e-5))]  # fmt: skip
    expected.append(pytest.approx(zar, rel=2e-5, abs=0))
    if math.isnan(low):  # the libraries' formula has no answer; ours is 95 % of the cycle
        low, high = mean - 171.0, mean + 171.0
    expected += [pytest.approx(v, abs=1e-3) for v in (low % 360, high % 360)]
    assert found(r) == expected
    twin = found(r - 1e-4)
    for value, wanted in zip(twin[:4], expected, strict=False):
        assert value != wanted
    # the exact p agrees with Zar's where that is above 0.001, and is smaller below
    exact = rayleigh_p(n, r)
    assert exact == pytest.approx(zar, rel=0.16) if zar > 1e-3 else 0 < exact < zar
    assert math.isnan(low) == math.isnan(found(r)[4])

"""Settings of restitution: what counts as a flight, what belongs to u, what is warned of."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FlightSettings:
    """How flights are fitted to the posterior of the joint estimate. Chosen by hand where nothing else is said.

    Attributes
    ----------
    steps, enough
        Of Gauss-Newton at most so many; a step that gains less in ln L is the last.
    least_and_most_g, drag_1_m
        Least and most g over that of the place, largest |k| that a step may try: outside, the series of the drag
        diverges.
    min_flight_s
        And the shortest flight it may try.
    parameter_step, time_step
        Of central differences: in g and k, and in times, places and velocities (SI units).
    after_onset_s
        Left to the spline after the onset: the release is not a clean cut.
    max_coefficients
        In each coordinate a dense fit takes so many, about 8 s of motion.
    near_g, about_g
        Shares of g. A last segment whose acceleration is off by more than the first may be cut by the record's end; one
        of 50 ms that is off by more than the second does not fall: the sphere lay, or was carried back.
    near_vertical_deg
        Below this tilt of the floor the same breaks are impacts along its normal as along the vertical.
    good_misfit, slack
        A fit is good below chi-square = good_misfit n + slack, n degrees of freedom; below -slack, which rounding does
        not reach, the samples do not determine it.
    min_excess
        Reported where chi-square exceeds n, and what the setup's uncertainties explain, by so many of its standard
        deviations. Of 16 laboratory drops the 12 that were right had -1.2 to 1.2, four that were wrong 2.3 to 135.
    min_bend
        And where the motion is off its flights by this many u, root mean square. Ten laboratory drops without walls had
        0.04 to 0.44, one that is 1.2 mm off 1.2.
    min_widening
        Then the statistical u of track, e and g grow by the Birge ratio, and by this at least: a motion that gives way
        shows less than it is wrong by (rms error over rms u 1.3 to 4 in four drops of another series).
    max_unexplained
        Where the motion keeps to its flights it is reported that they do not fit where chi-square, whatever the setup
        is off by, is above n by so many standard deviations: of 20 laboratory drops that were right it was at most 5,
        where the oscillator stepped by 6e-5 20 to 48 (three drops).
    shortest_fall_s
        A first fall alone lasts at least so long: over less, g is known to no more than some percent.
    before_contact_s
        It ends so much before the first misfit: one knot spacing, since the spline feels a contact before it comes.
    max_alternatives
        The heaviest so many alternatives are fitted; lighter ones hardly move the sum.
    widened
        Factor on u of g, impacts and speeds for what the maps cannot follow: of 164 simulated falls (benchmark
        accuracy) 92 % had g within 2u without it, 97 % with it.
    usable_u_e, most_e
        e is valid with u_e and e below these: a rebound faster than the arrival is no passive one.
    check_step_s
        Heights for the cross-check are taken so far apart.
    """

    steps: int = 20
    enough: float = 1e-3
    least_and_most_g: tuple[float, float] = (0.51, 1.53)
    drag_1_m: float = 2.0
    min_flight_s: float = 1e-3
    parameter_step: float = 1e-3
    time_step: float = 1e-5
    after_onset_s: float = 0.010
    max_coefficients: int = 800
    near_g: float = 0.051
    about_g: float = 0.255
    near_vertical_deg: float = 1.0
    good_misfit: float = 1.5
    slack: float = 20.0
    min_excess: float = 2.0
    min_bend: float = 1.0
    min_widening: float = 2.0
    max_unexplained: float = 10.0
    shortest_fall_s: float = 0.050
    before_contact_s: float = 0.010
    max_alternatives: int = 3
    widened: float = 1.2
    usable_u_e: float = 0.05
    most_e: float = 1.2
    check_step_s: float = 0.001


@dataclass(frozen=True, slots=True)
class TrackSettings:
    """How flights are fitted to a track. Chosen by hand where nothing else is said.

    Attributes
    ----------
    clearance_s
        Kept free around an impact, whose instant is known to about a millisecond before the flights are fitted.
    start_clearance_s
        Kept free after the start of the motion: the release is not a clean cut.
    min_flight_s
        Shortest flight, between the clearances.
    rising_s, min_rising_s
        The speed after the last impact comes from the track in so long after it, of which so much is known.
    min_known_s
        Of a flight, from its first known sample to its last.
    min_samples
        Of whatever a line or a parabola is fitted to, at any rate: twice the unknowns of a parabola, and two.
    largest_residual, min_residual_m
        A flight is no parabola where it misses its own by the second, and by the first times what the run's flights do.
    largest_shift_s
        Flights meet no farther from where an impact was seen: 10 ms windows found it.
    largest_g_error
        Flights under a g wrong by more than this share are none: what looked like impacts came from elsewhere.
    alike_g
        Unless each of them has the same g within this share: then it falls and bounces, but not with the g of the
        place, and that is told. What a hand does is no parabola twice. Chosen by hand.
    min_fall_s
        Known of a fall by itself.
    side_s, min_side_s
        Velocities at an impact come from straight lines, gravity taken off, over so long on each side, of which so much
        is known: sideways a flight is straight.
    waves_in_rebounds
        u of e by what parabolas follow of waves in the track, in units of e u(height) / rebound's height: of 340
        impacts of physical, generic and laboratory drops 80 to 100 % lay within 2 u without it, 89 to 100 % with it.
    sure_of_drag, much_drag
        Drag that flights show counts where it is above so many times that of the sphere assumed, by so many u: that of
        a sphere in air is known within 30 %.
    """

    clearance_s: float = 0.0015
    start_clearance_s: float = 0.02
    min_flight_s: float = 0.012
    rising_s: float = 0.012
    min_rising_s: float = 0.002
    min_known_s: float = 0.004
    min_samples: int = 8
    largest_residual: float = 5.0
    min_residual_m: float = 1.0e-3
    largest_shift_s: float = 0.005
    largest_g_error: float = 0.3
    alike_g: float = 0.15
    min_fall_s: float = 0.008
    side_s: float = 0.03
    min_side_s: float = 0.006
    waves_in_rebounds: float = 0.2
    sure_of_drag: float = 2.0
    much_drag: float = 1.5


@dataclass(frozen=True, slots=True)
class CheckSettings:
    """When the two other ways to e, and the plane of the impacts, speak. Chosen by hand where nothing else is said.

    Attributes
    ----------
    min_known_s
        Of the flight after an impact, for its height.
    edge_share
        Of that flight left out at both ends.
    coverage
        They disagree beyond so many standard uncertainties.
    model_share
        Of e, added to its u: air drag and a floor that gives way make the three differ by up to about a percent, none
        of them being wrong.
    min_speed_m_s
        After a slower rebound the next impact may be below what is resolved: nothing is said.
    longest_flight
        e from the flight time above which it was no flight: of three in a row with e = 1 the first impact shows 3.
    min_tilt_deg
        A tilt that the impacts found is reported where it is beyond `coverage` uncertainties above this: less is within
        what a floor laid with a spirit level has.
    min_braked_m
        A fall that is braked on a shorter way ended on something hard: 2 % of it are below what a track knows. What
        comes up again by less has no rebound.
    min_above_m
        A sphere so far above its parabola, beside `coverage` u, is braked.
    min_bounce_m_s
        A slower arrival or rebound says nothing of where the floor is.
    min_in_plane
        Fewer impacts say nothing of a plane.
    before_impact_s
        Their places come from the flights before them: from so long before the impact (or after the one before) to so
        long before it, where no smoothing has reached the corner.
    uneven_m
        Standard deviation of what a good floor is off its plane, and of how deep it is dented.
    given_tilt_deg
        Standard deviation of a normal that the setup gives.
    plane_sigmas
        Impacts are off one plane where chi-square is beyond its mean by so many deviations, once in a thousand: of
        190 drops that were right it was at most 4.3 a degree of freedom (decision 45), but 26 in one where a fringe was
        lost (30 mm, published).
    """

    min_known_s: float = 0.008
    edge_share: float = 0.05
    coverage: float = 3.0
    model_share: float = 0.01
    min_speed_m_s: float = 0.15
    longest_flight: float = 3.0
    min_tilt_deg: float = 0.5
    min_braked_m: float = 0.003
    min_above_m: float = 1e-4
    min_bounce_m_s: float = 0.1
    min_in_plane: int = 2
    before_impact_s: tuple[float, float] = (0.006, 0.0015)
    uneven_m: float = 2e-5
    given_tilt_deg: float = 0.2
    plane_sigmas: float = 3.1


@dataclass(frozen=True, slots=True)
class ContactSettings:
    """When impacts last so long that no instant stands for them. Chosen by hand on floors of 0 to 16 ms (decision 51).

    Attributes
    ----------
    min_s, longest_s
        Three times what the budget holds, so that longer ones are not in u of e; and what a rebound may take.
    coverage, coverage_of_track, coverage_of_conic
        So many standard uncertainties above zero; of what a track rounds, by circles that change with the place and by
        one for the whole motion: on hard floors at most 1.2 and 4.2 (ellipse, 23 dB).
    max_left
        Share of the misfit of one height that heights by speed may leave.
    worst_condition
        Of their equations: speeds of some percent's difference tell nothing.
    min_rounded_s, hidden_s
        Of what a corner's roundness shows: flights that end 1.5 ms before it hide so much.
    near_s, beside_s, min_samples
        The corner, and from where to where flights beside it are taken, by so many samples on each side.
    apart_m
        By which flights may miss each other at an impact, beside u.
    """

    min_s: float = 3e-4
    longest_s: float = 0.03
    coverage: float = 3.0
    coverage_of_track: float = 3.0
    coverage_of_conic: float = 6.0
    max_left: float = 0.1
    worst_condition: float = 1e4
    min_rounded_s: float = 6e-4
    hidden_s: float = 1.2e-3
    near_s: float = 5e-4
    beside_s: tuple[float, float] = (0.0015, 0.006)
    min_samples: int = 3
    apart_m: float = 1e-4


@dataclass(frozen=True, slots=True)
class TrackWallSettings:
    """When a track met a wall beside its fall. Chosen by hand on boxes and on drops without walls (decision 51).

    Attributes
    ----------
    clearance_s, min_flight_s
        Left out at both ends of a flight, and the shortest that tells, without them.
    parts
        Of a flight, whose means are looked at.
    min_jump_m_s, sigmas
        A flight turns aside by more than both.
    min_of_u
        And, root mean square, so many u of the track's places: 92 of 152 flights of boxes in which a wall was met, one
        of 1118 of drops without walls; of 0.7 it is 126, and 12.
    min_back_m_s, sigmas_back
        Of the speeds along the floor before and after an impact that throws back: both are above this and so many u.
    """

    clearance_s: float = 0.003
    min_flight_s: float = 0.03
    parts: int = 24
    min_jump_m_s: float = 0.1
    sigmas: float = 5.0
    min_of_u: float = 2.0
    min_back_m_s: float = 0.05
    sigmas_back: float = 2.0


@dataclass(frozen=True, slots=True)
class PathFitSettings:
    """How flights are fitted to path lengths. Chosen by hand where nothing else is said.

    Attributes
    ----------
    mean_s
        Means of the paths that are fitted: at 2 m/s they blur a quarter of a wavelength by 5 %.
    finest
        Period of the finest cosine in wavelengths: of what a mismatch leaves little has a shorter one.
    max_flights
        That are fitted together; those after them begin from what is known then.
    turns, steps
        Gauss-Newton steps, the last with widened waves, and steps of the variances in each.
    first_wave_m, first_noise_m, min_noise_m
        Deviations of cosines and of means that it begins with, and the least of both.
    min_means
        Of each flight.
    min_freedom, min_count
        Share of the samples that counts as free at least, and the least number of cosines that a variance is of.
    widened
        Factor on the deviation of the cosines at the end.
    min_u_g_m_s2, max_u_g_m_s2
        Of g that is called exact, and where nothing is known of it.
    min_u_k_1_m, min_u_slow_m_s
        Of drag k and its v1.
    """

    mean_s: float = 0.001
    finest: float = 0.25
    max_flights: int = 9
    turns: int = 4
    steps: int = 4
    first_wave_m: float = 5e-5
    first_noise_m: float = 3e-5
    min_noise_m: float = 1e-7
    min_means: int = 4
    min_freedom: float = 0.25
    min_count: float = 1e-3
    widened: float = 2.0
    min_u_g_m_s2: float = 1e-4
    max_u_g_m_s2: float = 100.0
    min_u_k_1_m: float = 1e-5
    min_u_slow_m_s: float = 0.03


FLIGHTS, TRACKS, CHECKS, PATHS = FlightSettings(), TrackSettings(), CheckSettings(), PathFitSettings()
CONTACTS, WALLS = ContactSettings(), TrackWallSettings()

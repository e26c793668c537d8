"""Settings of the simulated source."""

from __future__ import annotations

from radargui.gui.setup.fields import ChoiceField, NumberField
from radargui.gui.setup.form import Group
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

SCENES = {
    "drop": "Free fall with bounces",
    "circle": "Circle",
    "pendulum": "Pendulum",
    "bed": "Stop in a granular bed",
    "rest": "At rest",
}


class SimulatedForm(Group):
    """Scene, sphere and signal of the simulation."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__("Simulated source")

        def number(name: str, **options: object) -> NumberField:
            return NumberField(model, theme, f"simulation.{name}", **options)

        self.row("Scene", ChoiceField(model, "simulation.scene", SCENES))
        self.row(
            "Drop height [mm]",
            number("drop_height_m", scale=1000.0, optional=True, hint="release to floor"),
            "From the release to the floor; empty: what the release position and the floor give",
        )
        self.row("Restitution e", number("restitution"), "Coefficient of restitution of each impact")
        self.row("Lateral speed [m/s]", number("lateral_speed_m_s"), "Horizontal speed of the sphere at its release")
        self.row("SNR [dB]", number("snr_db"), "Signal-to-noise ratio of the white noise")
        self.row(
            "Mismatch [% of amplitude]",
            number("mismatch", scale=100.0),
            "Size of every kind of IQ mismatch that the setup file does not set by itself",
        )
        self.row("Seed", number("seed", whole=True), "Same seed, same noise")

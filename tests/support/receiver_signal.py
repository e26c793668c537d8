"""What one receiver shows at some places of the tracer."""

from __future__ import annotations

import numpy as np

from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.signal_model import ModelInputs, ReceiverSignal, signal_of, waves_at


def receiver_signal(
    node_m: np.ndarray, theta: np.ndarray, layout: Layout, inputs: ModelInputs, receiver: int
) -> ReceiverSignal:
    """Return the signal of a receiver at the nodes, shape (3, 2 channels, 2 nodes, n_bins)."""
    return signal_of(waves_at(node_m, theta, layout, inputs, receiver), theta, layout, inputs, receiver)

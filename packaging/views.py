"""The views of pandas and xarray where they are really installed: run by name, PYTHON packaging/views.py RUN."""

import sys

import numpy as np

import radargui

result = radargui.process(radargui.open_run(sys.argv[1]), correction="published")
table, data, bounces = result.to_pandas(), result.to_xarray(), result.bounces.to_pandas()
np.testing.assert_array_equal(table["z_m"], result.position_m[2])
np.testing.assert_array_equal(data["position_m"].sel(axis="z"), result.position_m[2])
assert bounces["e"][0] == result.bounces[0].e
print(table.tail(3).T, data, bounces, sep="\n\n")

"""Correct the IQ mismatch of each receiver by itself, and judge the result: published, ellipse, plug-ins.

Method 2, published and ellipse; method 6, Quality.
"""

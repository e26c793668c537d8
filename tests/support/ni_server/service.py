"""The calls of the NI-DAQmx service that an analogue input session makes, answered as the real server does."""

# the names are those of the service
# ruff: noqa: N802

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable
from typing import Any

import grpc
from nidaqmx._stubs import nidaqmx_pb2 as pb, nidaqmx_pb2_grpc
from nidaqmx.constants import AcquisitionType, Slope, TaskMode
from support.ni_server.devices import StandInDevice
from support.ni_server.edges import AnalogEdge, DigitalEdge
from support.ni_server.faults import Faults, NiError
from support.ni_server.meter import Meter
from support.ni_server.pace import Pace
from support.ni_server.precomputed import Precomputed
from support.ni_server.signal import Signal
from support.ni_server.task import TIMEOUT, Channel, StandInTask

VERSION = (24, 8, 0)
NOT_REACHABLE, INVALID_DEVICE, NO_SUCH_CHANNEL, RESERVED = -201003, -200220, -200170, -50103
UNKNOWN_ATTRIBUTE, NOT_FOR_THIS_DEVICE, INVALID_TASK = -200197, -200452, -200088


def rpc(method: Callable[..., Any]) -> Callable[..., Any]:
    """Make a method an RPC: counted, with the faults asked for, driver errors as trailing metadata."""

    @functools.wraps(method)
    def answer(self: DaqService, request: Any, context: grpc.ServicerContext) -> Any:
        name = method.__name__
        try:
            with self.pace.condition:
                self.calls[name] += 1
                self.faults.check(name)
                return method(self, request)
        except NiError as error:
            if error.code == TIMEOUT and name.startswith("Read"):
                return getattr(pb, f"{name}Response")(status=TIMEOUT, samps_per_chan_read=0)
            metadata = [("ni-error", str(error.code))]
            if error.samples_read is not None:
                metadata.append(("ni-samps-per-chan-read", str(error.samples_read)))
            context.set_trailing_metadata(tuple(metadata))
            context.abort(grpc.StatusCode.UNKNOWN, str(error))

    return answer


class DaqService(nidaqmx_pb2_grpc.NiDAQmxServicer):
    """The service: devices, tasks, faults."""

    def __init__(
        self, signal: Signal, devices: tuple[StandInDevice, ...], pace: Pace, made: Precomputed | None = None
    ) -> None:
        self.pace = pace
        self.meter = Meter()
        self._made_before = made
        self.devices = {device.name: device for device in devices}
        self.absent: set[str] = set()
        self.reserved_elsewhere: set[str] = set()
        self.tasks: dict[str, StandInTask] = {}
        self.calls: Counter[str] = Counter()
        self.faults = Faults()
        self._signal = signal
        self._made = 0

    def _device(self, name: str) -> StandInDevice:
        if name not in self.devices:
            raise NiError(INVALID_DEVICE)
        if name in self.absent:
            raise NiError(NOT_REACHABLE)
        return self.devices[name]

    def _input(self, physical: str) -> tuple[StandInDevice, int]:
        name, _, channel = physical.partition("/")
        device = self._device(name)
        if not channel.startswith("ai") or not channel[2:].isdigit() or int(channel[2:]) >= device.n_channels:
            raise NiError(NO_SUCH_CHANNEL)
        return device, int(channel[2:])

    def _task(self, request: Any) -> StandInTask:
        task = self.tasks.get(request.task.name)
        if task is None:
            raise NiError(INVALID_TASK)
        if task.channels and task.device.name in self.absent:
            raise NiError(NOT_REACHABLE)
        return task

    def _channel(self, request: Any) -> tuple[StandInTask, Channel]:
        task = self._task(request)
        for channel in task.channels:
            if channel.name == request.channel:
                return task, channel
        raise NiError(NO_SUCH_CHANNEL)

    @rpc
    def GetSystemInfoAttributeUInt32(self, request: Any) -> Any:
        order = (
            pb.SYSTEM_ATTRIBUTE_NIDAQ_MAJOR_VERSION,
            pb.SYSTEM_ATTRIBUTE_NIDAQ_MINOR_VERSION,
            pb.SYSTEM_ATTRIBUTE_NIDAQ_UPDATE_VERSION,
        )
        return pb.GetSystemInfoAttributeUInt32Response(value=VERSION[order.index(request.attribute_raw)])

    @rpc
    def GetSystemInfoAttributeString(self, request: Any) -> Any:
        return pb.GetSystemInfoAttributeStringResponse(value=", ".join(self.devices))

    @rpc
    def GetDeviceAttributeString(self, request: Any) -> Any:
        device = self._device(request.device_name)
        inputs = [f"{device.name}/ai{index}" for index in range(device.n_channels)]
        terminals = [f"/{device.name}/{line}" for line in (*device.trigger_lines, "ai/SampleClock", "20MHzTimebase")]
        value = {
            pb.DEVICE_ATTRIBUTE_PRODUCT_TYPE: device.product_type,
            pb.DEVICE_ATTRIBUTE_AI_PHYSICAL_CHANS: ", ".join(inputs),
            pb.DEVICE_ATTRIBUTE_TERMINALS: ", ".join(terminals),
        }
        return pb.GetDeviceAttributeStringResponse(value=_known(value, request))

    @rpc
    def GetDeviceAttributeUInt32(self, request: Any) -> Any:
        value = {pb.DEVICE_ATTRIBUTE_SERIAL_NUM: self._device(request.device_name).serial}
        return pb.GetDeviceAttributeUInt32Response(value=_known(value, request))

    @rpc
    def GetDeviceAttributeBool(self, request: Any) -> Any:
        device = self._device(request.device_name)
        value = {
            pb.DEVICE_ATTRIBUTE_IS_SIMULATED: False,
            pb.DEVICE_ATTRIBUTE_DIG_TRIG_SUPPORTED: bool(device.trigger_lines),
            pb.DEVICE_ATTRIBUTE_ANLG_TRIG_SUPPORTED: device.analog_trigger,
            pb.DEVICE_ATTRIBUTE_AI_SIMULTANEOUS_SAMPLING_SUPPORTED: device.simultaneous,
        }
        return pb.GetDeviceAttributeBoolResponse(value=_known(value, request))

    @rpc
    def GetDeviceAttributeDouble(self, request: Any) -> Any:
        device = self._device(request.device_name)
        value = {
            pb.DEVICE_ATTRIBUTE_AI_MAX_SINGLE_CHAN_RATE: device.max_single_hz,
            pb.DEVICE_ATTRIBUTE_AI_MAX_MULTI_CHAN_RATE: device.max_multi_hz,
            pb.DEVICE_ATTRIBUTE_AI_MIN_RATE: device.min_hz,
        }
        if device.n_channels == 0:
            raise NiError(UNKNOWN_ATTRIBUTE)
        return pb.GetDeviceAttributeDoubleResponse(value=_known(value, request))

    @rpc
    def GetDeviceAttributeDoubleArray(self, request: Any) -> Any:
        device = self._device(request.device_name)
        limits = [limit for limits in device.ranges_v for limit in limits] if device.n_channels else []
        value = {pb.DEVICE_ATTRIBUTE_AI_VOLTAGE_RNGS: limits}
        return pb.GetDeviceAttributeDoubleArrayResponse(value=_known(value, request))

    @rpc
    def GetDeviceAttributeInt32(self, request: Any) -> Any:
        device = self._device(request.device_name)
        value = {pb.DEVICE_ATTRIBUTE_AI_TRIG_USAGE: device.trigger_usage} if device.n_channels else {}
        return pb.GetDeviceAttributeInt32Response(value_raw=_known(value, request))

    @rpc
    def GetPhysicalChanAttributeInt32(self, request: Any) -> Any:
        device, index = self._input(request.physical_channel)
        value = {pb.PHYSICALCHANNEL_ATTRIBUTE_PHYSICAL_CHAN_AI_TERM_CFGS: device.terminals(index)}
        return pb.GetPhysicalChanAttributeInt32Response(value_raw=_known(value, request))

    @rpc
    def CreateTask(self, request: Any) -> Any:
        name = request.session_name or f"_unnamedTask<{self._made}>"
        self._made += 1
        self.tasks[name] = StandInTask(name, self._signal, self.pace, self.meter, self._made_before)
        response = pb.CreateTaskResponse(new_session_initialized=True)
        response.task.name = name
        return response

    @rpc
    def GetTaskAttributeString(self, request: Any) -> Any:
        value = {pb.TASK_ATTRIBUTE_NAME: self._task(request).name}
        return pb.GetTaskAttributeStringResponse(value=_known(value, request))

    @rpc
    def CreateAIVoltageChan(self, request: Any) -> Any:
        task = self._task(request)
        device, index = self._input(request.physical_channel)
        name = request.name_to_assign_to_channel or request.physical_channel
        task.add_channel(device, index, name, request.terminal_config_raw, request.min_val, request.max_val)
        return pb.CreateAIVoltageChanResponse()

    @rpc
    def CfgSampClkTiming(self, request: Any) -> Any:
        finite = request.sample_mode_raw == AcquisitionType.FINITE.value
        self._task(request).configure(request.rate, request.samps_per_chan, finite=finite)
        return pb.CfgSampClkTimingResponse()

    @rpc
    def CfgDigEdgeStartTrig(self, request: Any) -> Any:
        self._task(request).wait_for(DigitalEdge(request.trigger_source))
        return pb.CfgDigEdgeStartTrigResponse()

    @rpc
    def CfgDigEdgeRefTrig(self, request: Any) -> Any:
        self._task(request).wait_for(DigitalEdge(request.trigger_source), request.pretrigger_samples)
        return pb.CfgDigEdgeRefTrigResponse()

    @rpc
    def CfgAnlgEdgeStartTrig(self, request: Any) -> Any:
        self._task(request).wait_for(_analog_edge(request))
        return pb.CfgAnlgEdgeStartTrigResponse()

    @rpc
    def CfgAnlgEdgeRefTrig(self, request: Any) -> Any:
        self._task(request).wait_for(_analog_edge(request), request.pretrigger_samples)
        return pb.CfgAnlgEdgeRefTrigResponse()

    @rpc
    def SetTimingAttributeDouble(self, request: Any) -> Any:
        task = self._task(request)
        if request.attribute_raw != pb.TIMING_ATTRIBUTE_AI_CONV_RATE or task.device.simultaneous:
            raise NiError(NOT_FOR_THIS_DEVICE)
        task.convert_hz = request.value
        return pb.SetTimingAttributeDoubleResponse()

    @rpc
    def GetBufferAttributeUInt32(self, request: Any) -> Any:
        value = {pb.BUFFER_ATTRIBUTE_INPUT_BUF_SIZE: self._task(request).buffer}
        return pb.GetBufferAttributeUInt32Response(value=_known(value, request))

    @rpc
    def TaskControl(self, request: Any) -> Any:
        task = self._task(request)
        if request.action_raw in (TaskMode.TASK_COMMIT.value, TaskMode.TASK_RESERVE.value):
            self._reserve(task)
            task.commit()
        return pb.TaskControlResponse()

    @rpc
    def StartTask(self, request: Any) -> Any:
        task = self._task(request)
        self._reserve(task)
        task.start()
        return pb.StartTaskResponse()

    def _reserve(self, task: StandInTask) -> None:
        name = task.device.name
        others = (other for other in self.tasks.values() if other is not task and other.committed)
        if name in self.reserved_elsewhere or any(other.device.name == name for other in others):
            raise NiError(RESERVED)

    @rpc
    def GetTimingAttributeDouble(self, request: Any) -> Any:
        task = self._task(request)
        value = {pb.TIMING_ATTRIBUTE_SAMP_CLK_RATE: task.rate_hz}
        if not task.device.simultaneous:
            convert_hz = task.convert_hz or task.device.convert_hz(len(task.channels), task.rate_hz)
            value[pb.TIMING_ATTRIBUTE_AI_CONV_RATE] = convert_hz
        return pb.GetTimingAttributeDoubleResponse(value=_known(value, request, NOT_FOR_THIS_DEVICE))

    @rpc
    def GetChanAttributeUInt32(self, request: Any) -> Any:
        _, channel = self._channel(request)
        value = {pb.CHANNEL_ATTRIBUTE_AI_RAW_SAMP_SIZE: channel.device.raw_bits}
        return pb.GetChanAttributeUInt32Response(value=_known(value, request))

    @rpc
    def GetChanAttributeDoubleArray(self, request: Any) -> Any:
        task, channel = self._channel(request)
        value = {}
        if channel.device.scaling_told:
            value[pb.CHANNEL_ATTRIBUTE_AI_DEV_SCALING_COEFF] = task.coefficients(channel)
        return pb.GetChanAttributeDoubleArrayResponse(value=_known(value, request, NOT_FOR_THIS_DEVICE))

    @rpc
    def GetReadAttributeUInt32(self, request: Any) -> Any:
        value = {pb.READ_ATTRIBUTE_AVAIL_SAMP_PER_CHAN: self._task(request).available()}
        return pb.GetReadAttributeUInt32Response(value=_known(value, request))

    @rpc
    def ReadBinaryI16(self, request: Any) -> Any:
        return self._read(request, pb.ReadBinaryI16Response, codes=True)

    @rpc
    def ReadAnalogF64(self, request: Any) -> Any:
        return self._read(request, pb.ReadAnalogF64Response, codes=False)

    def _read(self, request: Any, response: Any, *, codes: bool) -> Any:
        task = self._task(request)
        samples, count, status = task.read(request.num_samps_per_chan, request.timeout, codes=codes)
        if request.task.name not in self.tasks or task.device.name in self.absent:
            raise NiError(NOT_REACHABLE, 0)
        if isinstance(samples, bytes):
            return samples
        # a short read is packed at the front, as the real driver does
        return response(status=status, read_array=samples.ravel().tolist(), samps_per_chan_read=count)

    @rpc
    def StopTask(self, request: Any) -> Any:
        self._task(request).stop()
        return pb.StopTaskResponse()

    @rpc
    def ClearTask(self, request: Any) -> Any:
        task = self.tasks.pop(request.task.name, None)
        if task is None:
            raise NiError(INVALID_TASK)
        task.stop()
        return pb.ClearTaskResponse()


def _analog_edge(request: Any) -> AnalogEdge:
    return AnalogEdge(request.trigger_source, request.trigger_level, request.trigger_slope_raw == Slope.RISING.value)


def _known(values: dict[int, Any], request: Any, otherwise: int = UNKNOWN_ATTRIBUTE) -> Any:
    if request.attribute_raw not in values:
        raise NiError(otherwise)
    return values[request.attribute_raw]

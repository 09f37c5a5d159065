"""A Modbus server of pymodbus, devices 1 to 9: `tcp`, `rtu` over TCP, or `serial PATH`.

Prints the port as soon as it listens. A line `0=3 1=8` of standard input sets holding registers. A coil that
is written shows in the holding register of 60 more, as the contact of a relay would.
"""

import asyncio
import socket
import sys

from pymodbus import FramerType
from pymodbus.server import ModbusSerialServer, ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

WORDS = [0] * 100


async def act(function, start, address, count, registers, values):
    if values is None:
        if function == 3:
            registers[: len(WORDS)] = WORDS
    elif function in (5, 15):
        for number, value in enumerate(values):
            WORDS[60 + address + number] = int(value)
    else:
        WORDS[address : address + len(values)] = values


async def main():
    words = [SimData(0, values=WORDS, datatype=DataType.REGISTERS)]
    bits = [SimData(0, values=[False] * 64, datatype=DataType.BITS)]
    blocks = (bits, bits, words, words)
    devices = [SimDevice(id=unit, simdata=blocks, action=act) for unit in range(1, 10)]
    port = 0
    if sys.argv[1] == "serial":
        line = {"port": sys.argv[2], "baudrate": 115200, "parity": "N", "stopbits": 2}
        server = ModbusSerialServer(devices, framer=FramerType.RTU, **line)
    else:
        framer = FramerType.RTU if sys.argv[1] == "rtu" else FramerType.SOCKET
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        server = ModbusTcpServer(devices, framer=framer, address=("127.0.0.1", port))
    await server.serve_forever(background=True)
    print(port, flush=True)
    reader = asyncio.StreamReader()
    protocol = asyncio.StreamReaderProtocol(reader)
    await asyncio.get_running_loop().connect_read_pipe(lambda: protocol, sys.stdin)
    while line := await reader.readline():
        for word in line.decode().split():
            address, value = word.split("=")
            WORDS[int(address)] = int(value)
    await server.shutdown()


asyncio.run(main())

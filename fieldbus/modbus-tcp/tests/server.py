"""A Modbus TCP server of the Python package `pymodbus`, for the test beside it.

Unit 1: coils 0 to 7; discrete inputs 0 to 7, which follow the coils; holding register 0 with 0x401, and 16 and 17.
Prints its port, and then a line for each write. Commands on its standard input: `slow MS`, `refuse CODE`, `ok`.
"""

import asyncio
import socket
import sys

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

coils = 0
slow = 0.0
refuse = None


async def action(function, start, address, count, registers, values):
    global coils
    await asyncio.sleep(slow)
    if refuse is not None:
        return ExcCodes(refuse)
    if function == 15:
        for at, on in enumerate(values):
            bit = 1 << (address + at)
            coils = coils | bit if on else coils & ~bit
        print("coils", coils, flush=True)
    if function == 16:
        print("register", address, values[0], flush=True)
    if function == 2:
        registers[0] = coils
    return None


async def commands():
    global slow, refuse
    reader = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    while line := (await reader.readline()).decode().split():
        slow = int(line[1]) / 1000 if line[0] == "slow" else 0.0
        refuse = int(line[1]) if line[0] == "refuse" else None
        print("done", flush=True)


async def main():
    bits = DataType.BITS
    device = SimDevice(
        id=1,
        simdata=(
            [SimData(0, values=[False] * 8, datatype=bits)],
            [SimData(0, values=[False] * 8, datatype=bits)],
            [
                SimData(0, values=0x401, datatype=DataType.REGISTERS),
                SimData(16, values=[0, 0], datatype=DataType.REGISTERS),
            ],
            [SimData(0, values=0, datatype=DataType.REGISTERS)],
        ),
        action=action,
    )
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = ModbusTcpServer(device, address=("127.0.0.1", port))
    await server.serve_forever(background=True)
    print("port", port, flush=True)
    await commands()


asyncio.run(main())

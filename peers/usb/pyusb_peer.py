"""PyUSB with a usbip backend at the virtual board: no virtual machine, no rights.

    pyusb_peer.py PORT      echoes through the image `usb_echo`
"""

import os
import subprocess
import sys
import time

PACKAGES = ["pyusb==1.3.1", "pyusb-usbip-backend==0.0.1"]


def environment(tools):
    """A Python of its own with both packages: its program."""
    folder = os.path.join(tools, "pyusb")
    stamp, wanted = os.path.join(folder, "installed"), " ".join(PACKAGES)
    if not os.path.exists(stamp) or open(stamp).read() != wanted:
        print(f"installing {wanted}", flush=True)
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([os.path.join(folder, "bin/pip"), "-q", "install", *PACKAGES], check=True)
        with open(stamp, "w") as out:
            out.write(wanted)
    return os.path.join(folder, "bin/python")


def main():
    import usb.core
    from usbip_backend.backend import get_backend

    device = usb.core.find(backend=get_backend("127.0.0.1", int(sys.argv[1]), timeout=10.0))
    device.set_configuration(1)
    [data] = [one for one in device.get_active_configuration() if one.bInterfaceClass == 10]
    to_device = next(one.bEndpointAddress for one in data if not one.bEndpointAddress & 0x80)
    from_device = next(one.bEndpointAddress for one in data if one.bEndpointAddress & 0x80)
    text, back, began = bytes(97 + index % 26 for index in range(16384)), b"", time.monotonic()
    for begin in range(0, len(text), 256):
        device.write(to_device, text[begin:begin + 256])
        while len(back) < begin + 256:
            back += bytes(device.read(from_device, 512))
    if back != text.upper():
        raise SystemExit("other bytes came back")
    trips = len(text) // 256
    print(f"{device.idVendor:04x}:{device.idProduct:04x}; {trips} times 256 bytes there and back, {(time.monotonic() - began) / trips * 1000:.1f} ms each")


if __name__ == "__main__":
    main()

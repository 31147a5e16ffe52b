"""A small Linux for QEMU, made of Debian's packages: its kernel, a few of its modules, busybox and the USB tools.

Nothing is installed: packages are downloaded and taken apart in a folder of the caller's.
"""

import glob
import gzip
import hashlib
import lzma
import os
import re
import shutil
import stat
import subprocess

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGES = ["busybox-static", "usbutils", "dfu-util", "dosfstools", "libusb-1.0-0", "libudev1", "libc6", "usbip", "eject",
            "libmount1", "libblkid1", "libselinux1", "libpcre2-8-0"]
# What the guest needs; what these need in turn is read out of them.
MODULES = ["virtio_pci", "virtio_console", "virtio_net", "9pnet_virtio", "9p", "xhci_pci", "cdc_acm", "usb_storage", "crct10dif_generic", "crc64_rocksoft_generic",
           "sd_mod", "nls_cp437", "nls_ascii", "nls_utf8", "vfat"]
# Loaded when it is wanted: it brings sixteen empty hubs with it.
LATER = ["vhci_hcd"]
FILES = ["bin/busybox", "usr/bin/lsusb", "usr/bin/dfu-util", "sbin/fsck.fat", "sbin/mkfs.fat", "usr/sbin/usbip", "usr/bin/eject"]
LIBRARIES = ["libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "ld-linux-x86-64.so.2", "libudev.so.1", "libusb-1.0.so.0",
             "libmount.so.1", "libblkid.so.1", "libselinux.so.1", "libpcre2-8.so.0"]


class Missing(Exception):
    """Something that has to be installed first: its words say what."""


def kernel_package():
    """The package of Debian's present kernel."""
    said = subprocess.run(["apt-cache", "depends", "linux-image-amd64"], capture_output=True, text=True)
    found = re.search(r"Depends: (linux-image-\S+)", said.stdout)
    if said.returncode or not found:
        raise Missing("Debian's package lists with linux-image-amd64 (apt-get update), on a computer of the amd64 architecture")
    return found.group(1)


def versions(names):
    """The packages with the versions that would be downloaded."""
    said = subprocess.run(["apt-cache", "policy", *names], capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"}).stdout
    return dict(zip(names, re.findall(r"Candidate: (\S+)", said)))


def download(folder, names):
    """The packages, taken apart: where their files are."""
    debs, root = os.path.join(folder, "debs"), os.path.join(folder, "root")
    for path in (debs, root):
        shutil.rmtree(path, ignore_errors=True)
        os.makedirs(path)
    said = subprocess.run(["apt-get", "download", *names], cwd=debs, capture_output=True, text=True)
    if said.returncode:
        why = said.stderr.strip().splitlines()[-1]
        raise Missing(f"Debian's packages, to download (apt-get update, if its lists are old): {why}")
    for deb in glob.glob(os.path.join(debs, "*.deb")):
        subprocess.run(["dpkg-deb", "-x", deb, root], check=True)
    shutil.rmtree(debs)
    return root


def vmlinux(root):
    """The kernel as an ELF file, out of the compressed one: QEMU starts that in half the time."""
    [path] = glob.glob(os.path.join(root, "boot/vmlinuz-*"))
    with open(path, "rb") as file:
        image = file.read()
    # Linux/x86 boot protocol: setup_sects, payload_offset, payload_length.
    begin = (image[0x1F1] + 1) * 512 + int.from_bytes(image[0x248:0x24C], "little")
    payload = image[begin:begin + int.from_bytes(image[0x24C:0x250], "little")]
    if payload[:6] != b"\xfd7zXZ\0":
        raise Missing("a kernel that is compressed with xz, as Debian's are")
    return lzma.LZMADecompressor().decompress(payload)


def read_module(path):
    """A module's bytes; it may be compressed."""
    with open(path, "rb") as file:
        content = file.read()
    return lzma.decompress(content) if path.endswith(".xz") else content


def modules(root):
    """The modules with all that they need, in an order in which they load: names and bytes, of those for the start and of those for later."""
    paths = {}
    for path in glob.glob(os.path.join(root, "lib/modules/*/kernel/**/*.ko*"), recursive=True):
        paths[os.path.basename(path).split(".ko")[0].replace("-", "_")] = path
    order, loaded = [], set()

    def load(name):
        if name in loaded:
            return
        loaded.add(name)
        if name not in paths:
            # Built in, or gone from this kernel.
            return
        content = read_module(paths[name])
        needs = re.search(rb"\0depends=([^\0]*)\0", b"\0" + content)
        for needed in filter(None, needs.group(1).decode().split(",") if needs else []):
            load(needed.replace("-", "_"))
        order.append((name, content))

    for name in MODULES:
        load(name)
    at_once = len(order)
    for name in LATER:
        load(name)
    return order[:at_once], order[at_once:]


class Archive:
    """An initramfs: a cpio archive of the "newc" format."""

    def __init__(self):
        self.content, self.folders, self.number = bytearray(), set(), 1

    def add(self, name, data, mode):
        parent = os.path.dirname(name)
        if parent and parent not in self.folders:
            self.folders.add(parent)
            self.add(parent, b"", stat.S_IFDIR | 0o755)
        fields = (self.number, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(name) + 1, 0)
        self.content += b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
        self.pad()
        self.content += data
        self.pad()
        self.number += 1

    def pad(self):
        self.content += bytes(-len(self.content) % 4)

    def file(self, name, data):
        self.add(name, data, stat.S_IFREG | 0o755)

    def whole(self):
        self.add("TRAILER!!!", b"", 0)
        return bytes(self.content)


def find(root, name):
    """A file in any folder of libraries."""
    return next(path for path in glob.glob(os.path.join(root, "**", name), recursive=True) if os.path.isfile(path))


def initramfs(root):
    archive = Archive()
    with open(os.path.join(HERE, "init"), "rb") as file:
        archive.file("init", file.read())
    for name in FILES:
        with open(os.path.join(root, name), "rb") as file:
            archive.file(name, file.read())
    for name in LIBRARIES:
        with open(find(root, name), "rb") as file:
            archive.file(f"lib/x86_64-linux-gnu/{name}", file.read())
    archive.add("lib64", b"lib/x86_64-linux-gnu", stat.S_IFLNK | 0o777)
    for list_name, order in zip(("order", "later"), modules(root)):
        for name, content in order:
            archive.file(f"modules/{name}", content)
        archive.file(f"modules/{list_name}", " ".join(name for name, _ in order).encode())
    # The first console, before anything is mounted.
    archive.add("dev", b"", stat.S_IFDIR | 0o755)
    return gzip.compress(archive.whole(), 1)


def prepare(folder):
    """Kernel and initramfs in this folder, made if they are not there yet, and the versions they are made of."""
    missing = [program for program in ("qemu-system-x86_64", "apt-get", "dpkg-deb") if not shutil.which(program)]
    if missing:
        packages = {"qemu-system-x86_64": "qemu-system-x86"}
        raise Missing(f"{' and '.join(missing)} (apt-get install --no-install-recommends {' '.join(packages.get(one, one) for one in missing)})")
    os.makedirs(folder, exist_ok=True)
    kernel = kernel_package()
    of = versions([kernel, *PACKAGES])
    recipe = hashlib.sha256()
    for path in (os.path.join(HERE, "init"), os.path.abspath(__file__)):
        with open(path, "rb") as file:
            recipe.update(file.read())
    stamp, wanted = os.path.join(folder, "made"), f"{sorted(of.items())} {recipe.hexdigest()}"
    paths = os.path.join(folder, "vmlinux"), os.path.join(folder, "initrd.gz")
    if not os.path.exists(stamp) or open(stamp).read() != wanted:
        print(f"making a guest of {kernel} {of[kernel]}", flush=True)
        root = download(folder, [kernel, *PACKAGES])
        for path, content in zip(paths, (vmlinux(root), initramfs(root))):
            with open(path, "wb") as out:
                out.write(content)
        shutil.rmtree(root)
        with open(stamp, "w") as out:
            out.write(wanted)
    return (*paths, of)

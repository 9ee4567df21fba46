"""Code, memory and stack of the small build on a Cortex-M4F beside VQF and Fusion, and the same samples there and here.

    ./run study small

Needs gcc-arm-none-eabi, libstdc++-arm-none-eabi-newlib and qemu-system-arm; the samples are those of BROAD trial 07.
"""

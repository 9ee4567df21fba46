# ARM Cortex-M4 with its unit for single precision, without an operating system: gcc-arm-none-eabi of Debian, or that of ARM.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m4)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
# A program needs the memory map of its board, which the compiler's tests have not.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(hnav_cortex_flags "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16")
set(CMAKE_C_FLAGS_INIT "${hnav_cortex_flags}")
# How GCC 7 passed some arguments does not matter here.
set(CMAKE_CXX_FLAGS_INIT "${hnav_cortex_flags} -Wno-psabi")

# What every FMU consists of beside its model and the entry points of a version.
set(hnav_fmu_adapter instance.cpp variables.cpp model_exchange.cpp saved_state.cpp)
list(TRANSFORM hnav_fmu_adapter PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
# The FMUs whose use of it is fuzzed, and whose corpora the tests replay.
set(hnav_fuzzed_fmus Hrekf Ahrs Ins)

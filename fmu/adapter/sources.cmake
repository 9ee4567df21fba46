# What every FMU consists of beside its model and the entry points of a version.
set(hnav_fmu_adapter ${CMAKE_CURRENT_LIST_DIR}/instance.cpp ${CMAKE_CURRENT_LIST_DIR}/model_exchange.cpp
    ${CMAKE_CURRENT_LIST_DIR}/saved_state.cpp)

// A model around one object of the library: its creation, destruction and saved state. Shared by all FMUs.
#pragma once

#include "adapter/model.hpp"
#include "hnav/hnav.h"

#include <cstring>
#include <type_traits>

namespace hnav::fmu {

// The library's calls for an object. An object without a history has no state to save.
template <class T, void (*destroy_)(T*), const char* (*message_)(const T*),
          hnav_status (*state_size_)(const T*, std::size_t*) = nullptr,
          hnav_status (*save_)(const T*, void*, std::size_t) = nullptr,
          hnav_status (*load_)(T*, const void*, std::size_t) = nullptr>
struct LibraryObject {
    using Object = T;
    static constexpr auto destroy = destroy_;
    static constexpr auto message = message_;
    static constexpr auto state_size = state_size_;
    static constexpr auto save = save_;
    static constexpr auto load = load_;
};

// Base: Model or StatelessModel. Calls: a LibraryObject. Memory: state of the model beside the object, such as its sampling
// clocks; eight-byte numbers, saved bytewise.
template <class Base, class Calls, class Memory>
class LibraryModel : public Base {
    static_assert(std::is_trivially_copyable_v<Memory> && sizeof(Memory) % 8 == 0);
    static constexpr bool has_history = Calls::state_size != nullptr;

public:
    std::size_t state_size() const final {
        std::size_t bytes = 0;
        if constexpr (has_history) Calls::state_size(object_, &bytes);
        return sizeof memory_ + bytes;
    }

    void save(void* buffer) const final {
        std::memcpy(buffer, &memory_, sizeof memory_);
        if constexpr (has_history)
            Calls::save(object_, static_cast<char*>(buffer) + sizeof memory_, state_size() - sizeof memory_);
    }

    bool load(const void* buffer, std::size_t bytes, Message* why) final {
        if (bytes < sizeof memory_ || (!has_history && bytes != sizeof memory_)) return false;
        if constexpr (has_history) {
            Memory memory;
            std::memcpy(&memory, buffer, sizeof memory);
            if (!fit(memory, why)) return false;
            const char* state = static_cast<const char*>(buffer) + sizeof memory_;
            if (!done(Calls::load(object_, state, bytes - sizeof memory_), why)) return false;
        }
        std::memcpy(&memory_, buffer, sizeof memory_);
        return true;
    }

    void clear() final {
        Calls::destroy(object_);
        object_ = nullptr;
        for (Message& why : refused_) why.text[0] = '\0';
    }

    const char* refused(Refusal by) const final { return refused_[by].text[0] != '\0' ? refused_[by].text : nullptr; }

protected:
    ~LibraryModel() override { Calls::destroy(object_); }

    // Creates the object; the arguments stand between the place of the object and that of the reason.
    template <class Create, class... Arguments>
    bool make(Message* why, Create create, const Arguments&... arguments) {
        clear();
        memory_ = {};
        return create(&object_, arguments..., why->text, sizeof why->text) == HNAV_OK;
    }

    // Likewise in place of the present object, which stays if there is none; the memory stays.
    template <class Create, class... Arguments>
    bool remake(Message* why, Create create, const Arguments&... arguments) {
        typename Calls::Object* made = nullptr;
        if (create(&made, arguments..., why->text, sizeof why->text) != HNAV_OK) return false;
        Calls::destroy(object_);
        object_ = made;
        return true;
    }

    // Prepares the object for the state saved beside this memory.
    virtual bool fit(const Memory&, Message*) { return true; }

    // Converts the status of a call, with its reason.
    bool done(hnav_status status, Message* why) const {
        if (status != HNAV_OK) std::snprintf(why->text, sizeof why->text, "%s", Calls::message(object_));
        return status == HNAV_OK;
    }

    // Keeps the reason of the first refused value and of the first late one.
    void note_refusal(hnav_status status) {
        if (status != HNAV_ERROR_OUT_OF_RANGE && status != HNAV_ERROR_LATE_SAMPLE) return;
        Message& why = refused_[status == HNAV_ERROR_LATE_SAMPLE ? of_time : of_value];
        if (why.text[0] == '\0') done(status, &why);
    }

    typename Calls::Object* object_ = nullptr;
    Memory memory_{};

private:
    Message refused_[refusals]{};
};

} // namespace hnav::fmu

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
    using Object = typename Calls::Object;

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
        Memory memory;
        std::memcpy(&memory, buffer, sizeof memory);
        if constexpr (has_history) {
            Object* other = nullptr;
            if (!make_other(memory, &other, why)) return false;
            Object* const into = other ? other : object_;
            const char* state = static_cast<const char*>(buffer) + sizeof memory;
            if (!done(into, Calls::load(into, state, bytes - sizeof memory), why)) {
                Calls::destroy(other);
                return false;
            }
            if (other) replace(other);
        }
        memory_ = memory;
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

    // Makes an object for the state saved beside this memory, where the present one cannot take it.
    virtual bool make_other(const Memory&, Object** /*other*/, Message* /*why*/) const { return true; }

    void replace(Object* other) {
        Calls::destroy(object_);
        object_ = other;
    }

    // Converts the status of a call, with its reason.
    static bool done(const Object* object, hnav_status status, Message* why) {
        if (status != HNAV_OK) std::snprintf(why->text, sizeof why->text, "%s", Calls::message(object));
        return status == HNAV_OK;
    }
    bool done(hnav_status status, Message* why) const { return done(object_, status, why); }

    // Keeps the reason of the first refused value and of the first late one.
    void note_refusal(hnav_status status) {
        if (status != HNAV_ERROR_OUT_OF_RANGE && status != HNAV_ERROR_LATE_SAMPLE) return;
        Message& why = refused_[status == HNAV_ERROR_LATE_SAMPLE ? of_time : of_value];
        if (why.text[0] == '\0') done(status, &why);
    }

    Object* object_ = nullptr;
    Memory memory_{};

private:
    Message refused_[refusals]{};
};

} // namespace hnav::fmu

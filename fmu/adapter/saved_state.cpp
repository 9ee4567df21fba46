// The complete state of an instance: taken, restored, and as bytes.
#include "adapter/instance.hpp"

#include <cstring>

namespace hnav::fmu {

// Plain numbers: header, values, the importer's states, the model. Valid in another process with the same binary.
struct Instance::Header {
    std::uint64_t magic, checksum;
    // The checksum covers everything from here on; it is computed when a state is serialised.
    std::uint64_t token, bytes;
    std::uint64_t interface, event_mode_used, mode, has_model;
    std::uint64_t parameters; // hash of the values that the model was created with
    double time_s, start_s, stop_s;
};

namespace {

constexpr std::uint64_t snapshot_magic = 0x3554415453564e48ull; // "HNVSTAT5": the last character counts versions
constexpr std::uint64_t version_bits = 0xffull << 56;
constexpr std::size_t unchecked_bytes = 2 * sizeof(std::uint64_t); // magic and checksum

std::uint64_t checksum(const unsigned char* bytes, std::size_t size) {
    Hash hash;
    for (std::size_t i = 0; i < size; ++i) hash.add(bytes[i]);
    return hash.value;
}

} // namespace

std::size_t Instance::snapshot_bytes() const {
    return sizeof(Header) + (value_count() + state_count_) * sizeof(double) +
           (has_model_ && !touched_ ? model_->state_size() : 0);
}

const unsigned char* Instance::model_in(const Snapshot* snapshot, std::size_t* bytes) const {
    const auto* place = reinterpret_cast<const unsigned char*>(snapshot + 1);
    Header header;
    std::memcpy(&header, place, sizeof header);
    const std::size_t before = sizeof header + (value_count() + state_count_) * sizeof(double);
    *bytes = snapshot->bytes - before;
    return header.has_model ? place + before : nullptr;
}

Status Instance::take_snapshot(Snapshot** snapshot) {
    if (!allowed(Call::fmu_state)) return Status::error;
    if (!snapshot) return fail("GetFMUState got a null pointer");
    const std::size_t bytes = snapshot_bytes();
    if (!*snapshot || (*snapshot)->bytes != bytes) {
        auto* fresh = static_cast<Snapshot*>(std::malloc(sizeof(Snapshot) + bytes));
        if (!fresh) return fail("no memory for the state of the FMU");
        release_snapshot(snapshot);
        *snapshot = fresh;
        fresh->bytes = bytes;
    } else release_model(*snapshot);
    auto* place = reinterpret_cast<unsigned char*>(*snapshot + 1);
    const bool saves_model = has_model_ && !touched_; // a model that must be created again has no state
    Header header{snapshot_magic, 0,           token_,      bytes,   options_.interface, options_.event_mode_used,
                  mode_,          saves_model, parameters_, time_s_, start_s_,           stop_s_};
    std::memcpy(place + sizeof header, values_, value_count() * sizeof(double));
    std::memcpy(place + sizeof header + value_count() * sizeof(double), states_, state_count_ * sizeof(double));
    if (saves_model) model_->save(place + bytes - model_->state_size());
    std::memcpy(place, &header, sizeof header);
    return Status::ok;
}

Status Instance::restore_snapshot(const Snapshot* snapshot) {
    if (!allowed(Call::fmu_state)) return Status::error;
    if (!snapshot) return fail("SetFMUState got a null pointer");
    const auto* place = reinterpret_cast<const unsigned char*>(snapshot + 1);
    Header header;
    std::memcpy(&header, place, sizeof header);
    if (header.interface != options_.interface || header.event_mode_used != static_cast<std::uint64_t>(options_.event_mode_used))
        return fail("this state was taken from an instance of another interface");
    const double* values = reinterpret_cast<const double*>(place + sizeof header);
    std::memcpy(values_, values, value_count() * sizeof(double));
    std::memcpy(states_, values + value_count(), state_count_ * sizeof(double));
    Message why;
    if (header.has_model) {
        const std::size_t used = sizeof header + (value_count() + state_count_) * sizeof(double);
        // A state from another process may need a model of its parameters first.
        const bool made = (has_model_ && parameters_ == header.parameters) ||
                          model_->initialise(values_, header.start_s, options_.interface == model_exchange, &why);
        if (!made || !model_->load(place + used, header.bytes - used, &why)) {
            restart();
            return fail("the state does not fit this instance: %s", why.text);
        }
    } else model_->clear();
    parameters_ = header.parameters;
    has_model_ = header.has_model != 0;
    touched_ = !has_model_;
    mode_ = static_cast<Mode>(header.mode);
    time_s_ = seen_s_ = header.time_s;
    start_s_ = header.start_s;
    stop_s_ = header.stop_s;
    stale_ = ~0u;
    return Status::ok;
}

void Instance::release_model(const Snapshot* snapshot) {
    std::size_t bytes = 0;
    if (const unsigned char* saved = model_in(snapshot, &bytes)) model_->release(saved, bytes);
}

Status Instance::release_snapshot(Snapshot** snapshot) {
    if (!snapshot) return Status::ok;
    if (*snapshot) release_model(*snapshot);
    std::free(*snapshot);
    *snapshot = nullptr;
    return Status::ok;
}

bool Instance::can_serialise(const Snapshot* snapshot) const {
    std::size_t bytes = 0;
    Message why;
    const unsigned char* saved = model_in(snapshot, &bytes);
    if (!saved || model_->can_serialise(saved, bytes, &why)) return true;
    fail("%s", why.text);
    return false;
}

Status Instance::get_snapshot_bytes(const Snapshot* snapshot, std::size_t* bytes) const {
    if (!snapshot || !bytes) return fail("SerializedFMUStateSize got a null pointer");
    if (!can_serialise(snapshot)) return Status::error;
    *bytes = snapshot->bytes;
    return Status::ok;
}

Status Instance::serialise(const Snapshot* snapshot, unsigned char* bytes, std::size_t size) const {
    if (!snapshot || !bytes) return fail("SerializeFMUState got a null pointer");
    if (!can_serialise(snapshot)) return Status::error;
    if (size < snapshot->bytes) return fail("SerializeFMUState got %zu bytes, the state has %zu", size, snapshot->bytes);
    std::memcpy(bytes, snapshot + 1, snapshot->bytes);
    Header header;
    std::memcpy(&header, bytes, sizeof header);
    header.checksum = checksum(bytes + unchecked_bytes, snapshot->bytes - unchecked_bytes);
    std::memcpy(bytes, &header, sizeof header);
    return Status::ok;
}

Status Instance::deserialise(const unsigned char* bytes, std::size_t size, Snapshot** snapshot) const {
    if (!snapshot || !bytes) return fail("DeserializeFMUState got a null pointer");
    Header header;
    if (size < sizeof header) return fail("a state has more than %zu bytes", size);
    std::memcpy(&header, bytes, sizeof header);
    if (header.magic != snapshot_magic && (header.magic | version_bits) == (snapshot_magic | version_bits))
        return fail("this state was saved by another version of the FMU");
    if (header.magic != snapshot_magic || header.token != token_ || header.bytes > size ||
        header.bytes < sizeof header + (value_count() + state_count_) * sizeof(double) ||
        header.checksum != checksum(bytes + unchecked_bytes, header.bytes - unchecked_bytes))
        return fail("these bytes are no state of this FMU, or damaged");
    auto* fresh = static_cast<Snapshot*>(std::malloc(sizeof(Snapshot) + header.bytes));
    if (!fresh) return fail("no memory for the state of the FMU");
    fresh->bytes = header.bytes;
    std::memcpy(fresh + 1, bytes, header.bytes);
    *snapshot = fresh;
    return Status::ok;
}

} // namespace hnav::fmu

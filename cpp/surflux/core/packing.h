#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "surflux/core/error.h"
#include "surflux/core/vec.h"

namespace surflux {

// Plain values as bytes, one after another, for another process of the same program.
class Packed {
public:
    template <class T>
    void add(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    // So many from an address; how many there are is for the reader to know.
    template <class T>
    void add(const T* first, std::size_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        if (count > 0) bytes_.append(reinterpret_cast<const char*>(first), count * sizeof(T));
    }
    // With how many there are.
    template <class T>
    void add(const std::vector<T>& values) {
        add(static_cast<std::uint64_t>(values.size()));
        add(values.data(), values.size());
    }
    std::string take() { return std::move(bytes_); }

private:
    std::string bytes_;
};

// Reads what a Packed holds, in the same order.
class Unpacking {
public:
    explicit Unpacking(const std::string& bytes) : bytes_(bytes) {}

    template <class T>
    T take() {
        T out;
        take(&out, 1);
        return out;
    }
    template <class T>
    void take(T* first, std::size_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        require_left(count, sizeof(T));
        if (count > 0) std::memcpy(static_cast<void*>(first), bytes_.data() + at_, count * sizeof(T));
        at_ += count * sizeof(T);
    }
    // Behind what is there.
    template <class T>
    void append_to(std::vector<T>& values) {
        const std::size_t before = values.size(), count = take<std::uint64_t>();
        require_left(count, sizeof(T));
        values.resize(before + count);
        take(values.data() + before, count);
    }
    void require_end() const {
        if (at_ != bytes_.size()) throw DeviceError("another process sent more than was wanted");
    }

private:
    void require_left(std::size_t count, std::size_t size) const {
        if (count > (bytes_.size() - at_) / size) throw DeviceError("what another process sent is cut off");
    }

    const std::string& bytes_;
    std::size_t at_ = 0;
};

// A hash of values (FNV-1a, by words of 64 bits), by which processes tell whether they have the same.
class Digest {
public:
    void add(std::uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3ull, hash_ ^= hash_ >> 29; }
    void add(double value) {
        std::uint64_t word;
        std::memcpy(&word, &value, sizeof(word));
        add(word);
    }
    void add(int value) { add(static_cast<std::uint64_t>(value)); }
    void add(const Vec3& v) { add(v.x), add(v.y), add(v.z); }
    template <class T>
    void add(const std::vector<T>& values) {
        for (const T& value : values) add(value);
    }
    std::uint64_t value() const { return hash_; }

private:
    std::uint64_t hash_ = 0xcbf29ce484222325ull;
};

template <class T>
std::uint64_t digest_of(const std::vector<T>& values) {
    Digest out;
    out.add(values);
    return out.value();
}

template <class T>
std::uint64_t digest_of(std::uint64_t seed, const std::vector<T>& values) {
    Digest out;
    out.add(seed);
    out.add(values);
    return out.value();
}

// Of what random numbers go by, and of where each of some places is.
template <class Place>
Digest digest_of_places(std::uint64_t seed, const std::vector<Place>& places) {
    Digest out;
    out.add(seed);
    for (const Place& place : places) {
        out.add(place.position);
        out.add(std::uint64_t{place.surfel});
    }
    return out;
}

template <class Place>
std::uint64_t digest_of_rays(std::uint64_t seed, const std::vector<Place>& places, const std::vector<int>& counts) {
    Digest out = digest_of_places(seed, places);
    out.add(counts);
    return out.value();
}

}  // namespace surflux

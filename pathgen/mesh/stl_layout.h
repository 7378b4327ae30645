#pragma once
// The bytes of a binary STL: 80 bytes of header, a 32-bit count, then records of 12 floats and a 16-bit
// attribute.

#include <bit>
#include <cstdint>

namespace tiltfeed::pathgen {

static_assert(std::endian::native == std::endian::little, "binary STL is read and written by copying");

inline constexpr std::uint64_t kHeaderBytes = 80;
inline constexpr std::uint64_t kDataStart = 84;
inline constexpr std::uint64_t kRecordBytes = 50;
inline constexpr std::uint64_t kNormalBytes = 12;

}  // namespace tiltfeed::pathgen

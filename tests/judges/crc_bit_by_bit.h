#pragma once
// The CRC-32 of registers bit by bit, high byte first: no table, and nothing of zlib.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tiltfeed {

using Words = std::vector<std::uint16_t>;

/// Over all words but the two at `hole`, which may lie past the end.
inline std::uint32_t crc_bit_by_bit(const Words& words, std::size_t hole) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i == hole || i == hole + 1) continue;
    for (const int byte : {words[i] >> 8, words[i] & 0xFF}) {
      crc ^= static_cast<std::uint32_t>(byte);
      for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
    }
  }
  return ~crc;
}

}  // namespace tiltfeed

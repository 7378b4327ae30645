#pragma once
// SHA-256 (FIPS 180-4) of a program file: the name under which a run's journal knows it.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "kinematics/basics/result.h"

namespace tiltfeed {

/// A digest of bytes that come in pieces.
class Sha256Sum {
 public:
  void add(std::string_view bytes);
  /// Of all that was added. The sum is used up.
  std::array<std::uint8_t, 32> finish();

 private:
  static constexpr std::size_t kChunk = 64;  // bytes of one round
  void round();

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, kChunk> chunk_{};
  std::size_t filled_ = 0;
  std::uint64_t length_ = 0;
};

std::array<std::uint8_t, 32> sha256(std::string_view bytes);
/// Of a file's content, read in pieces. Errors: kIo.
Result<std::array<std::uint8_t, 32>> sha256_of_file(const std::string& path);
/// 64 lower-case hexadecimal digits.
std::string hex(const std::array<std::uint8_t, 32>& digest);

}  // namespace tiltfeed

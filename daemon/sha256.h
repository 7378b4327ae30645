#pragma once
// SHA-256 (FIPS 180-4) of a program file: the name under which a run's journal knows it.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "kinematics/result.h"

namespace tiltfeed {

std::array<std::uint8_t, 32> sha256(std::string_view bytes);
/// Of a file's content, read in pieces. Errors: kIo.
Result<std::array<std::uint8_t, 32>> sha256_of_file(const std::string& path);
/// 64 lower-case hexadecimal digits.
std::string hex(const std::array<std::uint8_t, 32>& digest);

}  // namespace tiltfeed

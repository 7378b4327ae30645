#pragma once
// SHA-256 of a program file, by libgcrypt: the name under which a run's journal knows it.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct gcry_md_handle;

namespace tiltfeed::daemon {

/// A digest of bytes that come in pieces.
class Sha256Sum {
 public:
  Sha256Sum();
  void add(std::string_view bytes);
  /// Of all that was added. The sum is used up.
  std::array<std::uint8_t, 32> finish();

 private:
  std::unique_ptr<gcry_md_handle, void (*)(gcry_md_handle*)> sum_;
};

std::array<std::uint8_t, 32> sha256(std::string_view bytes);
/// 64 lower-case hexadecimal digits.
std::string hex(const std::array<std::uint8_t, 32>& digest);

}  // namespace tiltfeed::daemon

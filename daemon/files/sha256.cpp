#include "daemon/files/sha256.h"

#include <gcrypt.h>

#include <algorithm>
#include <cassert>

namespace tiltfeed::daemon {

namespace {

/// An open sum of libgcrypt, which is made ready before the first: no secret is kept here.
gcry_md_handle* open_sum() {
  [[maybe_unused]] static const bool ready = [] {
    if (gcry_control(GCRYCTL_INITIALIZATION_FINISHED_P)) return true;
    gcry_check_version(nullptr);
    gcry_control(GCRYCTL_DISABLE_SECMEM, 0);
    gcry_control(GCRYCTL_INITIALIZATION_FINISHED, 0);
    return true;
  }();
  gcry_md_hd_t sum = nullptr;
  [[maybe_unused]] const gcry_error_t failed = gcry_md_open(&sum, GCRY_MD_SHA256, 0);
  assert(!failed);
  return sum;
}

}  // namespace

Sha256Sum::Sha256Sum() : sum_(open_sum(), gcry_md_close) {}

void Sha256Sum::add(std::string_view bytes) { gcry_md_write(sum_.get(), bytes.data(), bytes.size()); }

std::array<std::uint8_t, 32> Sha256Sum::finish() {
  std::array<std::uint8_t, 32> digest;
  std::copy_n(gcry_md_read(sum_.get(), GCRY_MD_SHA256), digest.size(), digest.begin());
  return digest;
}

std::array<std::uint8_t, 32> sha256(std::string_view bytes) {
  Sha256Sum sum;
  sum.add(bytes);
  return sum.finish();
}

std::string hex(const std::array<std::uint8_t, 32>& digest) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace tiltfeed::daemon

#include "desk/webhooks/signature.h"

#include <gcrypt.h>

#include <array>

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kDigestBytes = 32;

void ready_gcrypt() {
  [[maybe_unused]] static const char* const ready = gcry_check_version(nullptr);  // before any use of it
}

std::string digits_of(const std::array<unsigned char, kDigestBytes>& bytes) {
  std::string text;
  for (const unsigned char byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

}  // namespace

std::string sha256_digits(std::string_view bytes) {
  ready_gcrypt();
  std::array<unsigned char, kDigestBytes> digest{};
  gcry_md_hash_buffer(GCRY_MD_SHA256, digest.data(), bytes.data(), bytes.size());
  return digits_of(digest);
}

std::string signature_of(const std::string& secret, std::int64_t seconds, std::string_view body) {
  ready_gcrypt();
  const std::string stamp = std::to_string(seconds), signed_text = stamp + "." + std::string(body);
  std::array<gcry_buffer_t, 2> parts{};
  parts[0].data = const_cast<char*>(secret.data());
  parts[0].len = secret.size();
  parts[1].data = const_cast<char*>(signed_text.data());
  parts[1].len = signed_text.size();
  std::array<unsigned char, kDigestBytes> digest{};
  if (gcry_md_hash_buffers(GCRY_MD_SHA256, GCRY_MD_FLAG_HMAC, digest.data(), parts.data(), parts.size()) != 0)
    return {};  // out of memory: a receiver refuses it
  return "t=" + stamp + ",v1=" + digits_of(digest);
}

}  // namespace tiltfeed::desk

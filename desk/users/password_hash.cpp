#include "desk/users/password_hash.h"

#include <crypt.h>

#include <array>
#include <memory>

#include "desk/session/secret.h"

namespace tiltfeed::desk {
namespace {

constexpr unsigned long kCost = 5;  // the default of yescrypt

std::string crypted(const std::string& password, const std::string& setting) {
  const auto data = std::make_unique<crypt_data>();  // 32 KiB
  const char* const hash = ::crypt_rn(password.c_str(), setting.c_str(), data.get(), sizeof *data);
  return hash ? hash : "";
}

}  // namespace

Result<std::string> hash_password(const std::string& password) {
  if (password.size() < kLeastPassword || password.size() > kMostPassword)
    return fail(Code::kUsage, "the password has " + std::to_string(password.size()) + " bytes; " +
                                  std::to_string(kLeastPassword) + " to " + std::to_string(kMostPassword) +
                                  " are allowed");
  if (password.find('\0') != std::string::npos) return fail(Code::kUsage, "the password has a byte 0");
  std::array<char, CRYPT_GENSALT_OUTPUT_SIZE> setting{};
  if (!::crypt_gensalt_rn("$y$", kCost, nullptr, 0, setting.data(), static_cast<int>(setting.size())))
    return fail(Code::kIo, "libxcrypt makes no salt for yescrypt");
  const std::string hash = crypted(password, setting.data());
  if (hash.empty()) return fail(Code::kIo, "libxcrypt makes no yescrypt hash");
  return hash;
}

bool password_matches(const std::string& password, const std::string& hash) {
  if (password.size() > kMostPassword || password.find('\0') != std::string::npos) return false;
  const std::string made = crypted(password, hash);
  return !made.empty() && made[0] != '*' && same_secret(made, hash);
}

}  // namespace tiltfeed::desk

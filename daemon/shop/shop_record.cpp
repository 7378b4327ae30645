#include "daemon/shop/shop_record.h"

#include <array>
#include <random>

namespace tiltfeed::daemon {

ShopTrust judge_shop(const ShopMark& mark, const ShopMark& found) {
  if (mark.shop != found.shop || found.epoch > mark.epoch) return ShopTrust::kNew;
  if (found.epoch < mark.epoch || found.epoch_id != mark.epoch_id || found.token < mark.token ||
      found.serial < mark.serial)
    return ShopTrust::kRestored;
  return ShopTrust::kSame;
}

bool is_uuid(const std::string& text) {
  constexpr std::size_t kLength = 36;
  if (text.size() != kLength) return false;
  for (std::size_t i = 0; i < kLength; ++i) {
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    const char c = text[i];
    const bool digit = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
    if (dash ? c != '-' : !digit) return false;
  }
  return true;
}

std::string make_uuid() {
  constexpr char kDigits[] = "0123456789abcdef";
  std::random_device random;
  std::array<unsigned, 16> bytes{};
  for (unsigned& byte : bytes) byte = random() & 0xFFU;
  bytes[6] = (bytes[6] & 0x0FU) | 0x40U;
  bytes[8] = (bytes[8] & 0x3FU) | 0x80U;
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += kDigits[bytes[i] >> 4U];
    text += kDigits[bytes[i] & 0xFU];
  }
  return text;
}

}  // namespace tiltfeed::daemon

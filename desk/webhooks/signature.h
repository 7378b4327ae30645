#pragma once
// What proves to a receiver that a message is ours and new.

#include <cstdint>
#include <string>
#include <string_view>

namespace tiltfeed::desk {

/// SHA-256 of the bytes, 64 lower-case hexadecimal digits.
std::string sha256_digits(std::string_view bytes);

/// The value of X-Tiltfeed-Signature: "t=SECONDS,v1=" and the HMAC-SHA256 of "SECONDS.BODY" [RFC 2104] in
/// lower-case hexadecimal digits. `seconds`: since 1970.
std::string signature_of(const std::string& secret, std::int64_t seconds, std::string_view body);

}  // namespace tiltfeed::desk

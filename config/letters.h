#pragma once
// What a letter of a text is, whatever the locale.

namespace tiltfeed::config {

constexpr bool is_digit(char letter) { return letter >= '0' && letter <= '9'; }

}  // namespace tiltfeed::config

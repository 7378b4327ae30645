#pragma once
// What a person sends who asks for help: one text, in sections, without secrets.

#include <string>
#include <string_view>

namespace tiltfeed::daemon {

/// The text with "***" in the place of: the rest of a line after a word that ends in password, passphrase,
/// secret, token or their like (passwd, pwd, _key, cookie, csrf, authorization), or after the word pass, and
/// is followed by : or =, and where nothing or a YAML block follows, the lines below that are further in;
/// what follows --password and Bearer; a private key in PEM; user and password of an address
/// (://USER:PASSWORD@); what follows the # of an http address, as that is a desk's sign-in. Lines and
/// everything else stay. Pure.
std::string without_secrets(std::string_view text);

/// "==== TITLE ====", the text without secrets, a line's end.
std::string support_section(const std::string& title, const std::string& text);

/// The last `most` bytes of a file, from a line's begin on; or why it cannot be read.
std::string tail_of_file(const std::string& path, std::size_t most);

}  // namespace tiltfeed::daemon

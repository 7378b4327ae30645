#pragma once
// The file of `tiltfeed desk --access F`: where the page is served on a network, and to whom. Every key:
// config/desk.yaml.

#include <string>
#include <vector>

#include "config/webhook_keys.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::config {

struct DeskAccess {
  std::string address = "127.0.0.1";  ///< IPv4
  int port = 0;
  std::vector<std::string> names;  ///< HOST or HOST:PORT as browsers address it
  std::string users;               ///< file; empty: the token of the address signs in
  std::string tokens;              ///< file of programs' tokens; empty: none
  std::string certificate, key;    ///< files (PEM); empty: no TLS of our own
  bool behind_proxy = false;       ///< TLS is a reverse proxy's
  std::vector<Webhook> webhooks;   ///< who is told of runs that are done or end in a fault
  std::string state;               ///< folder of what outlives the desk; empty: there are no webhooks
  std::string queue;  ///< address of the shop's queue, which `--shop` shows; empty: not said here

  bool is_https() const { return behind_proxy || !certificate.empty(); }
};

/// Relative paths start at the file's folder. Property: another address than this computer's own has users
/// and TLS. Errors: kInput as file:line:column, kIo.
Result<DeskAccess> load_desk_access(const std::string& path);
/// The same without the secrets of the webhooks, whose files are not read.
Result<DeskAccess> parse_desk_access(const std::string& text, const std::string& path);

}  // namespace tiltfeed::config

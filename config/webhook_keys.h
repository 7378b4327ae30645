#pragma once
// The keys `webhooks` of config/desk.yaml: who is told when a run is done, and when it ends in a fault.

#include <string>
#include <vector>

#include "config/section.h"

namespace tiltfeed::config {

struct Webhook {
  std::string url;          ///< http or https
  std::string host;         ///< of the URL, with its port where it states one: for messages
  std::string secret_file;  ///< what signs is its only line
  std::string secret;       ///< stands in no message; empty: not read
  bool done = true, fault = true;
};

/// What an event is sent to, by the key `webhooks`. `folder`: where relative files start. `secrets`: the
/// files are read, too. Problems are complaints at their keys.
std::vector<Webhook> read_webhooks(const Section& root, const std::string& folder, bool secrets);

/// HOST or HOST:PORT of a URL that a webhook may have. Errors: kInput: what is wrong with it.
Result<std::string> webhook_host(const std::string& url);

/// The one line of a file that nobody else may read. Errors: kInput, kIo: what is wrong and what to do;
/// nothing of the file stands in them.
Result<std::string> read_secret_file(const std::string& path);

}  // namespace tiltfeed::config

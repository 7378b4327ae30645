#include "config/desk_access.h"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "config/queue_key.h"
#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr std::size_t kMostNames = 16;
constexpr int kMostPort = 65535;

/// ADDRESS:PORT, IPv4. False: it is none.
bool split(const std::string& text, DeskAccess& access) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return false;
  access.address = text.substr(0, colon);
  in_addr parsed{};
  const char* const begin = text.data() + colon + 1;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(begin, end, access.port);
  return ::inet_pton(AF_INET, access.address.c_str(), &parsed) == 1 && begin != end && read.ptr == end &&
         read.ec == std::errc{} && access.port >= 0 && access.port <= kMostPort;
}

void read_webhook_keys(const Section& root, const std::string& path, bool secrets, DeskAccess& access) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  access.webhooks = read_webhooks(root, folder, secrets);
  if (!root.has("webhooks")) return root.unused("state", "without webhooks");
  const std::string state = root.text("state", "");
  if (state.empty())
    root.complain("webhooks",
                  "state is needed, too: a folder where deliveries wait, such as "
                  "/var/lib/tiltfeed-desk/NAME");
  access.state = (std::filesystem::path(folder) / state).lexically_normal().string();
}

Result<DeskAccess> parse(const std::string& text, const std::string& path, bool secrets) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint(path);
  const Section root(*tree, "",
                     {"listen", "names", "users", "tokens", "certificate", "key", "behind_proxy", "webhooks",
                      "state", "queue"},
                     complaint);
  const auto file = [&](const char* key) {
    const std::string name = root.text(key, "");
    if (name.empty()) return name;
    return (std::filesystem::path(path).parent_path() / name).lexically_normal().string();
  };
  DeskAccess access;
  const std::string listen = root.text("listen");
  if (!split(listen, access))
    root.complain("listen", "expected ADDRESS:PORT with an IPv4 address, found " + listen);
  access.names = root.lines("names", kMostNames);
  access.users = file("users");
  access.tokens = file("tokens");
  access.certificate = file("certificate");
  access.key = file("key");
  access.behind_proxy = root.flag("behind_proxy", false);
  if (access.certificate.empty() != access.key.empty())
    root.complain("listen", "certificate and key belong together");
  const bool here = access.address.rfind("127.", 0) == 0;
  if (!here && access.users.empty())
    root.complain("listen", access.address + " can be reached from other computers: users are needed");
  if (!here && !access.is_https())
    root.complain("listen", access.address +
                                " can be reached from other computers: certificate and key are needed, "
                                "or behind_proxy: true where a reverse proxy has them");
  if (access.is_https() && access.names.empty())
    root.complain("listen", "names are needed with TLS: by which name browsers address the page");
  read_webhook_keys(root, path, secrets, access);
  access.queue = root.text("queue", "");
  if (!access.queue.empty() && root.sound("queue"))
    if (const Result<void> good = check_queue_url(access.queue); !good)
      root.complain("queue", good.error().message);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  return access;
}

}  // namespace

Result<DeskAccess> parse_desk_access(const std::string& text, const std::string& path) {
  return parse(text, path, false);
}

Result<DeskAccess> load_desk_access(const std::string& path) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse(*text, path, true);
}

}  // namespace tiltfeed::config

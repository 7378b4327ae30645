#include "desk/webhooks/http_posts.h"

#include <curl/curl.h>
#include <sys/socket.h>

#include <algorithm>
#include <list>
#include <utility>

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kSaid = 160;  // bytes of an answer that are shown

struct Post {
  std::size_t lane = 0;
  CURL* easy = nullptr;
  curl_slist* headers = nullptr;
  std::string body, said;
  std::size_t got = 0, most = 0;
  Post() = default;
  Post(const Post&) = delete;
  Post& operator=(const Post&) = delete;
  ~Post() {
    curl_easy_cleanup(easy);
    curl_slist_free_all(headers);
  }
};

/// Less than all of it ends the request.
std::size_t take_head(const char*, std::size_t size, std::size_t count, void* its) {
  auto& post = *static_cast<Post*>(its);
  post.got += size * count;
  return post.got > post.most ? 0 : size * count;
}

std::size_t take_body(const char* bytes, std::size_t size, std::size_t count, void* its) {
  auto& post = *static_cast<Post*>(its);
  for (std::size_t i = 0; i < size * count && post.said.size() < kSaid; ++i)
    post.said += bytes[i] >= ' ' && bytes[i] < 0x7F ? bytes[i] : ' ';
  return take_head(bytes, size, count, its);
}

/// No program that is started meanwhile keeps the connection open.
curl_socket_t open_socket(void*, curlsocktype, curl_sockaddr* address) {
  return ::socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
}

std::string why_not(CURLcode code, const PostLimits& limits) {
  if (code == CURLE_OPERATION_TIMEDOUT)
    return "no answer within " + std::to_string(limits.whole.count() / 1000) + " s";
  return curl_easy_strerror(code);
}

PostAnswer answer_of(const Post& post, CURLcode code, const PostLimits& limits) {
  PostAnswer answer;
  long status = 0;
  curl_easy_getinfo(post.easy, CURLINFO_RESPONSE_CODE, &status);
  constexpr long kFinal = 200;  // below there is another to come
  if (status < kFinal) {
    answer.why = code == CURLE_OK ? "the answer has no status" : why_not(code, limits);
    return answer;
  }
  answer.status = static_cast<int>(status);
  answer.said = post.said;
  curl_off_t wish = 0;
  if (curl_easy_getinfo(post.easy, CURLINFO_RETRY_AFTER, &wish) == CURLE_OK && wish > 0)
    answer.retry_after = wish;
  return answer;
}

void set_up(Post& post, const std::string& url, const PostLimits& limits) {
  const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(post.easy, option, value); };
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_PROXY, "");
  set(CURLOPT_FORBID_REUSE, 1L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_QUICK_EXIT, 1L);  // a name that is looked up in vain keeps nobody waiting
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(limits.connect.count()));
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(limits.whole.count()));
  set(CURLOPT_OPENSOCKETFUNCTION, &open_socket);
  set(CURLOPT_HEADERFUNCTION, &take_head);
  set(CURLOPT_HEADERDATA, static_cast<void*>(&post));
  set(CURLOPT_WRITEFUNCTION, &take_body);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&post));
  set(CURLOPT_HTTPHEADER, post.headers);
  set(CURLOPT_POSTFIELDSIZE, static_cast<long>(post.body.size()));
  set(CURLOPT_POSTFIELDS, post.body.c_str());
  set(CURLOPT_PRIVATE, static_cast<void*>(&post));
}

}  // namespace

struct HttpPosts::State {
  CURLM* multi = nullptr;
  PostLimits limits;
  std::list<Post> posts;
  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    for (const Post& post : posts) curl_multi_remove_handle(multi, post.easy);
    posts.clear();
    curl_multi_cleanup(multi);
  }
};

HttpPosts::HttpPosts(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpPosts::HttpPosts(HttpPosts&& other) noexcept = default;
HttpPosts::~HttpPosts() = default;

Result<HttpPosts> HttpPosts::make(PostLimits limits) {
  static const CURLcode ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  auto state = std::make_unique<State>();
  state->limits = limits;
  if (ready == CURLE_OK) state->multi = curl_multi_init();
  if (!state->multi) return fail(Code::kIo, "libcurl cannot begin: no memory");
  return HttpPosts(std::move(state));
}

bool HttpPosts::start(std::size_t lane, const std::string& url, const std::vector<std::string>& headers,
                      const std::string& body) {
  Post& post = state_->posts.emplace_back();
  post.lane = lane;
  post.easy = curl_easy_init();
  post.body = body;
  post.most = state_->limits.answer;
  bool good = post.easy != nullptr;
  for (const std::string& line : headers) {
    curl_slist* const longer = good ? curl_slist_append(post.headers, line.c_str()) : nullptr;
    good = longer != nullptr;
    if (good) post.headers = longer;
  }
  if (good) {
    set_up(post, url, state_->limits);
    good = curl_multi_add_handle(state_->multi, post.easy) == CURLM_OK;
  }
  if (!good) state_->posts.pop_back();
  return good;
}

void HttpPosts::wait(std::chrono::milliseconds most, const std::vector<int>& descriptors) {
  std::vector<curl_waitfd> others;
  for (const int fd : descriptors) others.push_back({fd, CURL_WAIT_POLLIN, 0});
  curl_multi_poll(state_->multi, others.data(), static_cast<unsigned>(others.size()),
                  static_cast<int>(most.count()), nullptr);
}

void HttpPosts::wake() { curl_multi_wakeup(state_->multi); }

std::vector<HttpPosts::Ended> HttpPosts::turn() {
  int working = 0, left = 0;
  curl_multi_perform(state_->multi, &working);
  std::vector<Ended> ended;
  while (const CURLMsg* const message = curl_multi_info_read(state_->multi, &left)) {
    if (message->msg != CURLMSG_DONE) continue;
    CURL* const easy = message->easy_handle;
    const CURLcode code = message->data.result;
    const auto at = std::find_if(state_->posts.begin(), state_->posts.end(),
                                 [&](const Post& post) { return post.easy == easy; });
    ended.push_back({at->lane, answer_of(*at, code, state_->limits)});
    curl_multi_remove_handle(state_->multi, easy);
    state_->posts.erase(at);
  }
  return ended;
}

}  // namespace tiltfeed::desk

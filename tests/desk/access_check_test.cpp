#include "desk/http/access_check.h"

#include <gtest/gtest.h>

namespace tiltfeed::desk {
namespace {

const AccessRules kRules{{"127.0.0.1:8000", "localhost:8000"}};
const Sender kSignedIn{"secret"};

/// What the page itself sends.
Request change() {
  Request request;
  request.method = "POST";
  request.path = "/api/v1/part/unit";
  request.host = "127.0.0.1:8000";
  request.origin = "http://127.0.0.1:8000";
  request.fetch_site = "same-origin";
  request.content_type = "application/json";
  request.csrf = "secret";
  request.length = 12;
  return request;
}

Request look(const std::string& path) {
  Request request;
  request.method = "GET";
  request.path = path;
  request.host = "localhost:8000";
  return request;
}

int status(const Request& request, const Sender& sender) {
  const auto reply = refused(request, kRules, sender);
  return reply ? reply->status : 200;
}

TEST(AccessCheck, refuses_headers_that_stand_twice) {
  Request doubled = change();
  doubled.doubled = true;
  EXPECT_EQ(status(doubled, kSignedIn), 400);
}

TEST(AccessCheck, takes_what_the_page_sends) {
  EXPECT_EQ(status(change(), kSignedIn), 200);
  EXPECT_EQ(status(look("/"), {}), 200);
  EXPECT_EQ(status(look("/page.js"), {}), 200);
  EXPECT_EQ(status(look("/api/v1/state"), kSignedIn), 200);
}

TEST(AccessCheck, figures_need_who_is_signed_in_or_a_token) {
  Sender program;
  program.program = true;
  for (const char* const path : {"/metrics", "/api/v1/metrics"}) {
    EXPECT_EQ(status(look(path), {}), 401) << path;
    EXPECT_EQ(status(look(path), kSignedIn), 200) << path;
    EXPECT_EQ(status(look(path), program), 200) << path;
  }
}

/// One thing is changed in a request that would pass; each has to be refused.
TEST(AccessCheck, refuses_each_fault_by_itself) {
  struct Case {
    const char* what;
    void (*spoil)(Request&);
    int status;
  };
  const Case cases[] = {
      {"no host", [](Request& r) { r.host.clear(); }, 403},
      {"a rebound name",
       [](Request& r) { r.host = "evil.example:8000", r.origin = "http://evil.example:8000"; }, 403},
      {"another port", [](Request& r) { r.host = "127.0.0.1:8001", r.origin = "http://127.0.0.1:8001"; },
       403},
      {"a host that begins like ours", [](Request& r) { r.host += ".evil.example"; }, 403},
      {"no origin", [](Request& r) { r.origin.clear(); }, 403},
      {"a sandboxed page", [](Request& r) { r.origin = "null"; }, 403},
      {"another site", [](Request& r) { r.origin = "http://evil.example"; }, 403},
      {"our other name", [](Request& r) { r.origin = "http://localhost:8000"; }, 403},
      {"TLS that is not there", [](Request& r) { r.origin = "https://127.0.0.1:8000"; }, 403},
      {"another site's fetch", [](Request& r) { r.fetch_site = "cross-site"; }, 403},
      {"another port's fetch", [](Request& r) { r.fetch_site = "same-site"; }, 403},
      {"typed into the address bar", [](Request& r) { r.fetch_site = "none"; }, 403},
      {"a form", [](Request& r) { r.content_type = "application/x-www-form-urlencoded"; }, 415},
      {"a form with a file", [](Request& r) { r.content_type = "multipart/form-data"; }, 415},
      {"a form of text", [](Request& r) { r.content_type = "text/plain; application/json"; }, 415},
      {"no type", [](Request& r) { r.content_type.clear(); }, 415},
      {"no length", [](Request& r) { r.length.reset(); }, 411},
      {"chunks", [](Request& r) { r.transfer_encoding = "chunked"; }, 411},
      {"no csrf secret", [](Request& r) { r.csrf.clear(); }, 403},
      {"another csrf secret", [](Request& r) { r.csrf = "secreT"; }, 403},
      {"a longer csrf secret", [](Request& r) { r.csrf = "secrets"; }, 403},
      {"a change of the page", [](Request& r) { r.path = "/"; }, 405},
      {"an unknown method", [](Request& r) { r.method = "TRACE"; }, 405},
  };
  for (const Case& at : cases) {
    Request request = change();
    at.spoil(request);
    EXPECT_EQ(status(request, kSignedIn), at.status) << at.what;
  }
}

TEST(AccessCheck, refuses_the_api_to_who_is_not_signed_in) {
  EXPECT_EQ(status(look("/api/v1/state"), {}), 401);
  EXPECT_EQ(status(change(), {}), 401);
  Request sign_in = change();
  sign_in.path = kSignIn;
  sign_in.csrf.clear();
  EXPECT_EQ(status(sign_in, {}), 200);
  sign_in.origin = "http://evil.example";
  EXPECT_EQ(status(sign_in, {}), 403);
  Request cross = look("/api/v1/state");
  cross.fetch_site = "cross-site";
  EXPECT_EQ(status(cross, kSignedIn), 403);
  cross.host = "evil.example:8000";
  EXPECT_EQ(status(cross, kSignedIn), 403);
}

TEST(AccessCheck, a_program_is_known_by_its_token_alone) {
  const Sender submits{"", true, true}, watches{"", false, true};
  Request own = change();
  own.origin.clear(), own.csrf.clear(), own.fetch_site.clear();
  EXPECT_EQ(status(own, submits), 200);
  EXPECT_EQ(status(own, watches), 403);
  EXPECT_EQ(status(look("/api/v1/state"), watches), 200);
  // What a page of another site sends is refused, whatever it states.
  for (const auto& spoil :
       {+[](Request& r) { r.origin = "http://evil.example"; },
        +[](Request& r) { r.fetch_site = "cross-site"; }, +[](Request& r) { r.host = "evil.example:8000"; },
        +[](Request& r) { r.path = kSignIn; }}) {
    Request request = own;
    spoil(request);
    EXPECT_EQ(status(request, submits), 403);
  }
}

TEST(AccessCheck, reads_cookies_and_codings) {
  EXPECT_EQ(cookie_value("a=1; tiltfeed-80=x; b=2", "tiltfeed-80"), "x");
  EXPECT_EQ(cookie_value("tiltfeed-8000=y;tiltfeed-80=x", "tiltfeed-80"), "x");
  EXPECT_EQ(cookie_value("xtiltfeed-80=y", "tiltfeed-80"), "");
  EXPECT_EQ(cookie_value("", "tiltfeed-80"), "");
  EXPECT_EQ(cookie_value(";;=;", "tiltfeed-80"), "");
  for (const char* yes : {"gzip", "br, gzip", "gzip;q=0.5", "*", "deflate, gzip ; q=1"})
    EXPECT_TRUE(accepts_gzip(yes)) << yes;
  for (const char* no : {"", "br", "gzip;q=0", "gzip; q=0.000", "gzipped"})
    EXPECT_FALSE(accepts_gzip(no)) << no;
}

}  // namespace
}  // namespace tiltfeed::desk

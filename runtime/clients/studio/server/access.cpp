#include "runtime/clients/studio/server/access.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>

#include <httplib.h>  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {
namespace {

std::string random_token() {
  std::array<unsigned char, 16> bits;
  if (::getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size()))
    throw Error("no-random-numbers", "the system provides no random numbers");
  std::string out;
  for (const auto b : bits) out += fmt::format("{:02x}", b);
  return out;
}

// Compares in constant time, so that response times reveal nothing about the token.
bool equal(const std::string& a, const std::string& b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference = difference | (a[i] ^ b[i]);
  return difference == 0;
}

Access::Refusal refused(int status, const char* code, const char* message, std::string hint) {
  return {status, {Severity::Error, code, message, std::move(hint), {}, "", ""}};
}

bool is_loopback(const std::string& host) {
  for (const std::string name : {"127.0.0.1", "localhost"}) {
    if (host == name) return true;
    if (host.starts_with(name + ":") && host.size() > name.size() + 1 &&
        host.find_first_not_of("0123456789", name.size() + 1) == std::string::npos)
      return true;
  }
  return false;
}

}  // namespace

Access::Access(std::string command) : command_(std::move(command)), token_(random_token()) {}

std::string Access::address() const { return fmt::format("http://127.0.0.1:{}/?token={}", port_, token_); }

// All ports of a host share their cookies, so the cookie name contains the port.
std::string Access::cookie_name() const { return fmt::format("terrazzo_{}_{}", command_, port_); }

std::string Access::cookie() const {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict", cookie_name(), token_);
}

bool Access::is_from_our_page(const httplib::Request& in) {
  const std::string host = in.get_header_value("Host"), site = in.get_header_value("Sec-Fetch-Site");
  if (!is_loopback(host)) return false;
  // Ports of one host are one site to browsers, so the origin must be equal, port included.
  if (in.has_header("Origin") && in.get_header_value("Origin") != "http://" + host) return false;
  const bool opens_page = in.method == "GET" && in.path == "/" &&
                          in.get_header_value("Sec-Fetch-Mode") == "navigate" &&
                          in.get_header_value("Sec-Fetch-Dest") == "document";
  return site.empty() || site == "same-origin" || site == "none" || opens_page;
}

bool Access::has_token(const httplib::Request& in) const {
  if (in.has_param("token")) return equal(in.get_param_value("token"), token_);
  const std::string prefix = cookie_name() + "=";
  for (std::size_t k = 0; k < in.get_header_value_count("Cookie"); ++k) {
    const std::string all = in.get_header_value("Cookie", k);
    for (std::size_t at = 0; at < all.size();) {
      const std::size_t end = std::min(all.find(';', at), all.size());
      const std::size_t from = std::min(all.find_first_not_of(' ', at), end);
      const std::string one = all.substr(from, end - from);
      if (one.starts_with(prefix) && equal(one.substr(prefix.size()), token_)) return true;
      at = end + 1;
    }
  }
  return false;
}

std::optional<Access::Refusal> Access::refusal(const httplib::Request& in) const {
  if (!is_from_our_page(in))
    return refused(403, "foreign-origin", "the request comes from another site or names another host",
                   "open the address that terrazzo " + command_ + " prints");
  if (!has_token(in))
    return refused(403, "no-token", "the request does not contain the token of this session",
                   "open the complete address that terrazzo " + command_ + " prints");
  if (in.has_header("Transfer-Encoding") || in.has_header("Content-Encoding"))
    return refused(415, "encoded", "the request's body is chunked or encoded",
                   "send plain JSON with a Content-Length");
  return {};
}

}  // namespace terrazzo::studio

// Reading JSON that others wrote.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace terrazzo {

// Values nested deeper are refused: copying, comparing and writing them is recursive.
inline constexpr int kDeepestJson = 100;

// Throws Error "bad-json", which says what is wrong with the text.
nlohmann::json parse_json(std::string_view text);
// The same, but null if the text is not JSON.
nlohmann::json json_or_null(std::string_view text);
// The content of a file; null if it is not a regular file or not JSON. Throws Error "too-large" above 1 GiB,
// or if reading it could take more memory than is available.
nlohmann::json read_json_file(const std::filesystem::path&);

// Upper bound of the bytes that parsing needs, without the text.
double memory_to_read_json(std::string_view text);

// What is wrong, without the name that the library gives to the kind of exception: "type must be string, but
// is number".
std::string json_problem(const std::exception&);

}  // namespace terrazzo

#include "surflux/files/text_lines.h"

#include <charconv>
#include <cstring>
#include <limits>

namespace surflux {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

}  // namespace

bool parse_number(std::string_view word, double& value) {
    if (!word.empty() && word[0] == '+') {
        word.remove_prefix(1);
        if (!word.empty() && word[0] == '-') return false;
    }
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (stop != end || error == std::errc::invalid_argument) return false;
    if (error == std::errc::result_out_of_range) {
        const std::size_t exponent = word.find_first_of("eE");
        const bool tiny = exponent != std::string_view::npos && exponent + 1 < word.size() && word[exponent + 1] == '-';
        value = tiny             ? 0.0
                : word[0] == '-' ? -std::numeric_limits<double>::infinity()
                                 : std::numeric_limits<double>::infinity();
    }
    return true;
}

bool TextLines::advance() {
    while (next_ < end_) {
        at_ = next_;
        const void* newline = std::memchr(next_, newline_, static_cast<std::size_t>(end_ - next_));
        line_end_ = newline ? static_cast<const char*>(newline) : end_;
        next_ = newline ? line_end_ + 1 : end_;
        ++next_number_;
        while (at_ < line_end_ && is_blank(*at_)) ++at_;
        if (at_ < line_end_) return true;
    }
    return false;
}

bool TextLines::next_word(std::string_view& word) {
    while (at_ < line_end_ && is_blank(*at_)) ++at_;
    const char* begin = at_;
    while (at_ < line_end_ && !is_blank(*at_)) ++at_;
    word = std::string_view(begin, static_cast<std::size_t>(at_ - begin));
    return !word.empty();
}

std::string_view TextLines::rest() {
    while (at_ < line_end_ && is_blank(*at_)) ++at_;
    const char* begin = at_;
    const char* end = line_end_;
    while (end > begin && is_blank(end[-1])) --end;
    at_ = line_end_;
    return {begin, static_cast<std::size_t>(end - begin)};
}

TextLines::Word TextLines::next_number(double& value, std::string_view& word) {
    if (!next_word(word)) return Word::none;
    return parse_number(word, value) ? Word::number : Word::garbage;
}

}  // namespace surflux

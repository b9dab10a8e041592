#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace surflux {

// The lines of a text that are not blank, one after the other, and the words of the current one.
class TextLines {
public:
    enum class Word { none, garbage, number };

    // From `offset` on, which is the begin of line `number` (from 1). Lines end in `newline`; '\r' is a blank
    // otherwise.
    explicit TextLines(const std::string& bytes, std::size_t offset = 0, std::size_t number = 1, char newline = '\n')
        : next_(bytes.data() + offset),
          begin_(bytes.data()),
          end_(bytes.data() + bytes.size()),
          next_number_(number),
          newline_(newline) {}

    bool advance();                                          // to the next line; false at the end of the file
    std::size_t number() const { return next_number_ - 1; }  // of the current line, from 1
    std::size_t offset() const { return static_cast<std::size_t>(next_ - begin_); }  // of the line after it

    bool next_word(std::string_view& word);
    std::string_view rest();  // of the current line, without blanks around it
    Word next_number(double& value, std::string_view& word);

private:
    const char* at_ = nullptr;  // in the current line
    const char* line_end_ = nullptr;
    const char* next_;
    const char* begin_;
    const char* end_;
    std::size_t next_number_;
    char newline_;
};

// A number as C writes it, inf and nan included, whatever the locale. What is too small for a double is 0; too large,
// inf.
bool parse_number(std::string_view word, double& value);

}  // namespace surflux

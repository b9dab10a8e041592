// LeakSanitizer asks this function what to leave out. Mesa's OSMesa never frees the window of a context.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so\n"; }

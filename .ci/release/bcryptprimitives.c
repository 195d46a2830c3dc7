/* Stands for a library that Windows 7 and later have and Wine 8 lacks, from which Rust's standard library takes random
   numbers. For Wine alone (`wine_library`); never shipped. */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID bytes, ULONG length); /* RtlGenRandom */

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE bytes, SIZE_T length) {
    return SystemFunction036(bytes, (ULONG)length);
}

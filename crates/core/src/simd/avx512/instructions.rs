//! Types and instructions of 512 bits, under the names that the x86 widths share.

pub(super) use std::arch::x86_64::{
    __m512 as Floats, __m512i as Ints, __mmask16 as Bools, _mm512_add_epi32 as add_epi32,
    _mm512_add_ps as add_ps, _mm512_and_si512 as and_si, _mm512_castps_si512 as castps_si,
    _mm512_castsi512_ps as castsi_ps, _mm512_cmpeq_epi32_mask as cmpeq_epi32,
    _mm512_cmpgt_epi32_mask as cmpgt_epi32, _mm512_cvtepi32_ps as cvtepi32_ps,
    _mm512_cvttps_epi32 as cvttps_epi32, _mm512_div_ps as div_ps, _mm512_loadu_ps as loadu_ps,
    _mm512_loadu_si512 as loadu_si, _mm512_max_epi32 as max_epi32, _mm512_max_ps as max_ps,
    _mm512_min_epi32 as min_epi32, _mm512_min_ps as min_ps, _mm512_mul_ps as mul_ps,
    _mm512_mullo_epi32 as mullo_epi32, _mm512_or_si512 as or_si, _mm512_set1_epi32 as set1_epi32,
    _mm512_set1_ps as set1_ps, _mm512_shuffle_ps as shuffle_ps, _mm512_sll_epi32 as sll_epi32,
    _mm512_sqrt_ps as sqrt_ps, _mm512_sra_epi32 as sra_epi32, _mm512_srl_epi32 as srl_epi32,
    _mm512_storeu_ps as storeu_ps, _mm512_storeu_si512 as storeu_si, _mm512_sub_epi32 as sub_epi32,
    _mm512_sub_ps as sub_ps, _mm512_unpackhi_epi32 as unpackhi_epi32,
    _mm512_unpackhi_epi64 as unpackhi_epi64, _mm512_unpackhi_ps as unpackhi_ps,
    _mm512_unpacklo_epi32 as unpacklo_epi32, _mm512_unpacklo_epi64 as unpacklo_epi64,
    _mm512_unpacklo_ps as unpacklo_ps, _mm512_xor_ps as xor_ps, _mm512_xor_si512 as xor_si,
};

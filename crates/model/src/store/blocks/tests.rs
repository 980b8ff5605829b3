//! Laws of the block layer: it reads what was written, or refuses.

use super::*;
use crate::store::test_media::Memory;

fn filled() -> (Memory, Vec<u8>) {
    let memory = Memory::default();
    let blocks = Blocks::create(memory.clone()).unwrap();
    blocks.set_len(4 * BLOCK as u64).unwrap();
    blocks.write(0, b"head of the database").unwrap();
    let data: Vec<u8> = (0..2 * BLOCK).map(|i| (i % 251) as u8).collect();
    blocks.write(BLOCK as u64, &data).unwrap();
    (memory, data)
}

fn damage(error: &io::Error) -> Option<&CodecError> {
    error.get_ref()?.downcast_ref()
}

fn damaged_block(number: u64) -> String {
    format!("damaged: block {number} does not match its checksum")
}

#[test]
fn what_was_written_is_read_after_opening_again() {
    let (memory, data) = filled();
    let blocks = Blocks::open(memory).unwrap();
    assert_eq!(blocks.len().unwrap(), 4 * BLOCK as u64);
    let mut out = vec![0; data.len()];
    blocks.read(BLOCK as u64, &mut out).unwrap();
    assert_eq!(out, data);
    let mut head = vec![1; BLOCK];
    blocks.read(0, &mut head).unwrap();
    assert!(head.starts_with(b"head of the database\0") && head[BLOCK - 1] == 0);
}

#[test]
fn a_flipped_bit_anywhere_in_a_block_is_found() {
    let (memory, _) = filled();
    let image = memory.image();
    let mut out = vec![0; BLOCK];
    for place in 0..STORED_BLOCK {
        let mut bytes = image.clone();
        bytes[FIRST_BLOCK as usize + place] ^= 1 << (place % 8);
        let blocks = Blocks::open(Memory::of(bytes)).unwrap();
        let error = blocks.read(BLOCK as u64, &mut out).unwrap_err();
        assert_eq!(error.to_string(), damaged_block(1), "byte {place}");
    }
}

#[test]
fn a_block_in_the_wrong_place_and_one_never_written_are_found() {
    let (memory, _) = filled();
    let mut bytes = memory.image();
    let (first, second) = (FIRST_BLOCK as usize, FIRST_BLOCK as usize + STORED_BLOCK);
    bytes.copy_within(first..second, second);
    let blocks = Blocks::open(Memory::of(bytes)).unwrap();
    let mut out = vec![0; BLOCK];
    for number in [2, 3] {
        let error = blocks.read(number * BLOCK as u64, &mut out).unwrap_err();
        assert_eq!(error.to_string(), damaged_block(number));
    }
    let beyond = blocks.read(4 * BLOCK as u64, &mut out).unwrap_err();
    assert!(beyond.to_string().contains("outside of the file"), "{beyond}");
    assert!(blocks.read(u64::MAX - 1, &mut out).is_err());
}

#[test]
fn one_damaged_copy_of_the_head_loses_nothing_and_two_are_refused() {
    let (memory, _) = filled();
    for place in HEAD_PLACES {
        let mut bytes = memory.image();
        bytes[place as usize + 30] ^= 4;
        let blocks = Blocks::open(Memory::of(bytes)).unwrap();
        let mut head = [0; 20];
        blocks.read(0, &mut head).unwrap();
        assert_eq!(&head, b"head of the database");
    }
    let mut bytes = memory.image();
    HEAD_PLACES.iter().for_each(|&place| bytes[place as usize + 30] ^= 4);
    let error = Blocks::open(Memory::of(bytes)).unwrap_err();
    assert!(error.to_string().contains("neither copy of the head"), "{error}");
}

#[test]
fn the_later_of_two_sound_heads_counts() {
    let (memory, _) = filled();
    let before = memory.image();
    let blocks = Blocks::open(memory.clone()).unwrap();
    blocks.write(0, b"next").unwrap();
    drop(blocks);
    // The power went away between the two copies.
    let mut bytes = memory.image();
    let second = HEAD_PLACES[1] as usize..HEAD_PLACES[1] as usize + SECTOR;
    bytes[second.clone()].copy_from_slice(&before[second]);
    let blocks = Blocks::open(Memory::of(bytes)).unwrap();
    let mut head = [0; 4];
    blocks.read(0, &mut head).unwrap();
    assert_eq!(&head, b"next");
}

#[test]
fn cut_and_foreign_files_say_so() {
    let (memory, _) = filled();
    let image = memory.image();
    for length in [9, 11, 300, 512, 600, 2048, 4095, 5000, image.len() - 1] {
        let error = Blocks::open(Memory::of(image[..length].to_vec())).unwrap_err();
        assert!(matches!(damage(&error), Some(CodecError::Truncated { .. })), "{length}: {error}");
    }
    for text in [&b""[..], b"PK\x03\x04", b"{\"unit\":\"m\"}"] {
        let error = Blocks::open(Memory::of(text.to_vec())).unwrap_err();
        assert!(matches!(damage(&error), Some(CodecError::NotAModel)), "{error}");
    }
    let mut other = image.clone();
    other[8] = 1;
    let error = Blocks::open(Memory::of(other)).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "the file has format version 1; version {STORE_VERSION} is read here. Make the model \
             anew from its scan, or open it with the program that wrote it"
        )
    );
}
